# The server in a container: Debian's libraries, the binary and the sample meshes,
# run by a user who owns nothing but the store.
#
#     docker build -t geodesicd .
#     docker run -p 8080:8080 -v geodesicd:/var/lib/geodesicd geodesicd
#
# BASE may be any Debian 12 or 13.
ARG BASE=debian:bookworm-slim

FROM ${BASE} AS build
ARG DEBIAN_FRONTEND=noninteractive
RUN apt-get update -qq \
 && apt-get install -qq --yes --no-install-recommends make ca-certificates >/dev/null
WORKDIR /src
# First what says which packages are needed, so that a change to the code does not
# install them anew.
COPY Makefile ./
COPY scripts scripts
COPY cmake cmake
RUN GEODESICD_NO_BROWSER=1 make setup
COPY . .
RUN GEODESICD_NO_BROWSER=1 make build CMAKE_FLAGS="-DGEODESIC_TESTS=OFF -DGEODESIC_BENCH=OFF" \
 && mkdir /out \
 && scripts/build_viewer \
 && scripts/build_docs \
 && strip -o /out/geodesicd build/release/geodesicd \
 && build/release/make_samples /out/samples \
 && scripts/runtime_packages build/release/geodesicd >/out/packages \
 && scripts/licences build/release /out/licences

FROM ${BASE}
ARG DEBIAN_FRONTEND=noninteractive
COPY --from=build /out/packages /usr/local/share/geodesicd/packages
RUN apt-get update -qq \
 && xargs apt-get install -qq --yes --no-install-recommends curl \
      </usr/local/share/geodesicd/packages >/dev/null \
 && rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin \
 && useradd --uid 10001 --no-create-home --home-dir /var/lib/geodesicd \
      --shell /usr/sbin/nologin geodesicd \
 && install -d -o geodesicd -g geodesicd /var/lib/geodesicd
COPY --from=build /out/geodesicd /usr/local/bin/geodesicd
COPY --from=build /out/licences /usr/local/share/doc/geodesicd
COPY --from=build /out/samples /usr/local/share/geodesicd/samples
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
