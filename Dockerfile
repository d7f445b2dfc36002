# The server in a container: Debian's libraries, the binary and the sample meshes,
# run by a user who owns nothing but the store.
#
#     docker build -t geodesicd .
#     docker run -p 8080:8080 -v geodesicd:/var/lib/geodesicd geodesicd
#
# BASE may be any Debian 12 or 13. scripts/build_image builds it so that two builds are the same bytes.
ARG BASE=debian:bookworm-slim
# The time that files say they are from.
ARG SOURCE_DATE_EPOCH=0

FROM ${BASE} AS build
ARG DEBIAN_FRONTEND=noninteractive
ARG SOURCE_DATE_EPOCH
RUN apt-get update -qq \
 && apt-get install -qq --yes --no-install-recommends make ca-certificates >/dev/null
WORKDIR /src
# First what says which packages are needed, so that a change to the code does not
# install them anew.
COPY Makefile ./
COPY scripts scripts
COPY cmake cmake
RUN GEODESICD_NO_BROWSER=1 scripts/setup package
COPY . .
RUN GEODESICD_NO_BROWSER=1 scripts/build_shipped \
 && scripts/runtime_packages build/package/program >build/package/needed

FROM ${BASE} AS runtime
ARG DEBIAN_FRONTEND=noninteractive
ARG SOURCE_DATE_EPOCH
COPY --from=build /src/build/package/needed /usr/local/share/geodesicd/packages
# Without what apt leaves behind, which says when it ran.
RUN apt-get update -qq \
 && xargs apt-get install -qq --yes --no-install-recommends curl \
      </usr/local/share/geodesicd/packages >/dev/null \
 && useradd --uid 10001 --no-create-home --home-dir /var/lib/geodesicd \
      --shell /usr/sbin/nologin geodesicd \
 && install -d -o geodesicd -g geodesicd /var/lib/geodesicd \
 && rm -rf /var/lib/apt/lists/* /var/cache/apt/* /var/cache/debconf/*-old /var/lib/dpkg/*-old \
      /var/cache/ldconfig/aux-cache /var/log/apt/* /var/log/*.log /etc/passwd- /etc/group- /etc/shadow- \
      /etc/gshadow- /etc/subuid- /etc/subgid-

# The packages of the image, as CycloneDX.
FROM build AS sbom
COPY --from=runtime /var/lib/dpkg /runtime/var/lib/dpkg
COPY --from=runtime /etc/os-release /etc/debian_version /runtime/etc/
RUN scripts/write_sbom /runtime /sbom.cdx.json

FROM runtime
COPY --from=sbom /sbom.cdx.json /usr/local/share/doc/geodesicd/sbom.cdx.json
COPY --from=build /src/build/package/program /usr/local/bin/geodesicd
COPY --from=build /src/build/package/licences /usr/local/share/doc/geodesicd
COPY --from=build /src/build/package/samples /usr/local/share/geodesicd/samples
COPY --from=build /src/clients/web/viewer/dist /usr/local/share/geodesicd/viewer
COPY --from=build /src/build/docs /usr/local/share/geodesicd/docs

# By number, so that an orchestrator can tell that this is not root.
USER 10001
# As variables, so that flags and a configuration of one's own can override them.
ENV GEODESICD_LISTEN=0.0.0.0:8080 \
    GEODESICD_STORE=/var/lib/geodesicd \
    GEODESICD_SAMPLES=/usr/local/share/geodesicd/samples \
    GEODESICD_VIEWER=/usr/local/share/geodesicd/viewer \
    GEODESICD_DOCS=/usr/local/share/geodesicd/docs
EXPOSE 8080
VOLUME /var/lib/geodesicd
HEALTHCHECK --interval=10s --timeout=3s --start-period=10s \
  CMD address=${GEODESICD_ADMIN_LISTEN:-$GEODESICD_LISTEN}; scheme=http; \
      if [ -z "$GEODESICD_ADMIN_LISTEN" ] && [ -n "$GEODESICD_TLS_CERT" ]; then scheme=https; fi; \
      curl --silent --fail --insecure --output /dev/null "$scheme://127.0.0.1:${address##*:}/livez"
STOPSIGNAL SIGTERM
ENTRYPOINT ["/usr/local/bin/geodesicd"]
