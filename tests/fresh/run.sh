#!/usr/bin/env bash
# Proof that a bare machine is enough: in a new Debian root with git, make and
# ca-certificates only, a fresh clone of this repository (what is committed) goes
# through these stages:
#
#     setup   `make setup` works, and a second one finds nothing to do in under 1 s of processor time
#     test    `make test` passes
#     build   `make build` compiles everything for release (only if asked for: `test` does too)
#     run     `make run` starts, answers the curl line it prints and the first pages of the README's
#             three readers, and stops on Ctrl-C
#     image   buildah builds the Dockerfile on the same bare root, and the container
#             answers with a path
#
# usage: tests/fresh/run.sh [--suite bookworm|trixie]... [--stage STAGE]...
#                           [--folder DIR] [--keep] [--ccache]
#
#     --folder DIR   where roots are built (default: a new one in $TMPDIR); one that
#                    was kept is used again: its roots, and its clones if of the same commit
#     --keep         do not remove the folder at the end
#     --ccache       lend the roots this machine's ccache folder
#
# Needs root, debootstrap and (image) buildah. Not part of `make test`. The mirror,
# apt's proxy settings and local CA certificates are this machine's own.
#
# Exit status: 0 if all stages passed, 1 if one failed, 2 if something needed is not there,
# 3 if nothing failed but the making of a bare root.
set -euo pipefail
repository=$(cd "$(dirname "$0")/../.." && pwd)

suites=() stages=() folder="" keep="" ccache=""
while [ $# -gt 0 ]; do
  case $1 in
    --suite) suites+=("$2"); shift 2 ;;
    --stage) stages+=("$2"); shift 2 ;;
    --folder) folder=$2; shift 2 ;;
    --keep) keep=yes; shift ;;
    --ccache) ccache=${CCACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/ccache}; shift ;;
    *) sed -n '2,/^set -e/{/^set/d;s/^# \{0,1\}//p}' "$0"; exit 2 ;;
  esac
done
[ ${#suites[@]} -gt 0 ] || suites=(bookworm trixie)
[ ${#stages[@]} -gt 0 ] || stages=(setup test run image)

# shellcheck source=tests/fresh/roots.sh
. "$repository/tests/fresh/roots.sh"

if [ -z "$folder" ]; then
  folder=$(mktemp -d)
  if [ -z "$keep" ]; then
    trap 'rm -rf --one-file-system "$folder"' EXIT
  fi
fi
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
commit=$(git -C "$repository" rev-parse HEAD)
echo "fresh: commit $commit in $folder, from $mirror"

# stage SUITE STAGE COMMAND...: runs it, says how long it took and sets `outcome`.
# (Called on its own and not in an `if` or `||`, where bash would ignore `set -e`.)
failed=() outcome=0 rootless=0
stage() {
  local suite=$1 name=$2 started=$SECONDS
  shift 2
  echo "fresh: $suite: $name"
  set +e
  (set -e; "$@")
  outcome=$?
  set -e
  if [ $outcome -ne 0 ]; then
    echo "fresh: $suite: $name FAILED after $((SECONDS - started)) s"
    failed+=("$suite/$name")
  else
    echo "fresh: $suite: $name done in $((SECONDS - started)) s"
  fi
}

stage_setup() {
  local root=$1
  inside "$root" make setup
  # Processor time, because the machine may have other work.
  local took
  took=$(TIMEFORMAT='%U %S'; { time inside "$root" make setup >&2; } 2>&1 | tail -n 1)
  echo "fresh: the second make setup took $took s of processor time (user, system)"
  awk '{exit !($1 + $2 < 1)}' <<<"$took"
}

stage_run() {
  PORT=$(free_port) inside "$1" bash tests/fresh/make_run.sh
}

images() {
  buildah --root "$folder/images" --runroot "$folder/images.run" --storage-driver vfs "$@"
}

stage_image() {
  local suite=$1 base=localhost/fresh-base:$1 image=localhost/geodesicd:$1 container
  container=$(images from scratch)
  tar -C "$folder/$suite.base" --exclude './dev/*' --exclude './var/lib/apt/lists/*' -cf "$folder/$suite.tar" .
  images add --quiet "$container" "$folder/$suite.tar" /
  rm "$folder/$suite.tar"
  images commit --quiet --rm "$container" "$base"
  # The docker format, because OCI's has no health check.
  images build --isolation chroot --pull-never --format docker --layers=false \
    --build-arg "BASE=$base" --tag "$image" "$folder/$suite.root/src"
  container=$(images from --pull-never "$image")
  ask_container "$container"
}

# Starts the container's own entry point and asks for a path over its first sample.
ask_container() {
  local container=$1 port log=$folder/container.log server sample id url reply
  mapfile -t entry < <(images inspect --type container "$container" |
    jq -r '.Docker.config.Entrypoint[]')
  [ ${#entry[@]} -gt 0 ]
  # shellcheck disable=SC2016  # for the container's shell
  sample=$(images run --isolation chroot "$container" -- \
    sh -c 'id -u; sha256sum "$GEODESICD_SAMPLES"/* | sed -n 1p')
  echo "$sample"
  [ "$(sed -n 1p <<<"$sample")" -ne 0 ]
  # With the licences of what is in it.
  images run --isolation chroot "$container" -- sh -c \
    'cd /usr/local/share/doc/geodesicd && grep -il copyright geodesicd httplib three lib*-dev'
  id=$(sed -n '2s/ .*//p' <<<"$sample")
  port=$(free_port)
  url=http://127.0.0.1:$port
  unshare --mount --pid --fork --kill-child --mount-proc \
    buildah --root "$folder/images" --runroot "$folder/images.run" --storage-driver vfs \
    run --isolation chroot --env "GEODESICD_LISTEN=127.0.0.1:$port" "$container" -- \
    "${entry[@]}" >"$log" 2>&1 &
  server=$!
  for _ in $(seq 150); do
    curl --silent --fail --output /dev/null "$url/v1/meshes/$id" && break
    kill -0 "$server" 2>/dev/null || break
    sleep 0.2
  done
  local status=0
  reply=$(curl --silent --show-error --fail-with-body \
    "$url/v1/meshes/$id/path?from=v:0&to=v:5") || status=1
  echo "${reply:0:300}"
  jq --exit-status '.reachable and .length > 0' <<<"$reply" >/dev/null || status=1
  curl --silent --fail --output /dev/null "$url/livez" || status=1
  # unshare holds SIGTERM back; with it, all it has started is killed.
  kill -KILL "$server" 2>/dev/null || true
  wait "$server" 2>/dev/null || true
  [ $status -eq 0 ] || cat "$log"
  return $status
}

for suite in "${suites[@]}"; do
  root=$folder/$suite.root
  stage "$suite" root make_base "$suite"
  if [ $outcome -ne 0 ]; then
    rootless=$((rootless + 1))
    continue
  fi
  if [ ! -d "$root" ]; then
    cp -a --reflink=auto "$folder/$suite.base" "$root"
  fi
  if [ "$(git -C "$root/src" rev-parse HEAD 2>/dev/null)" != "$commit" ]; then
    rm -rf "$root/src"
    git clone --quiet "file://$repository" "$root/src"
  fi
  for name in "${stages[@]}"; do
    case $name in
      setup) stage "$suite" setup stage_setup "$root" ;;
      test) stage "$suite" test inside "$root" make test ;;
      build) stage "$suite" build inside "$root" make build ;;
      run) stage "$suite" run stage_run "$root" ;;
      image) stage "$suite" image stage_image "$suite" ;;
      *) echo "fresh: no stage is called '$name'" >&2; exit 2 ;;
    esac
    [ $outcome -eq 0 ] || break
  done
done
if [ ${#failed[@]} -gt 0 ]; then
  echo "fresh: failed: ${failed[*]}"
  [ ${#failed[@]} -gt $rootless ] || exit 3
  exit 1
fi
echo "fresh: all stages passed: ${suites[*]}: ${stages[*]}"
