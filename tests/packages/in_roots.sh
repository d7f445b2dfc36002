# shellcheck shell=bash
# What the tests of packages have in common: to be sourced by them, with their arguments in "$@" and
# `repository` set. Sets `folder`, `suites` and what is random, and removes the folder at the end
# unless it was named.

suites=() folder="" ccache="" package=""
while [ $# -gt 0 ]; do
  case $1 in
    --suite) suites+=("$2"); shift 2 ;;
    --package) package=$(realpath "$2"); shift 2 ;;
    --folder) folder=$2; shift 2 ;;
    --ccache) ccache=${CCACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/ccache}; shift ;;
    *) sed -n '2,/^set -e/{/^set/d;s/^# \{0,1\}//p}' "$0"; exit 2 ;;
  esac
done
[ ${#suites[@]} -gt 0 ] || suites=(bookworm trixie)
# shellcheck source=tests/fresh/roots.sh
. "$repository/tests/fresh/roots.sh"

seed=${GEODESICD_SEED:-$RANDOM}
echo "packages: seed $seed"
RANDOM=$seed
unset GEODESICD_URL
export no_proxy='*'

root="" suite="" started="" kept=$folder
finish() {
  [ -z "$started" ] || kill -KILL -- "-$started" 2>/dev/null || true
  [ -n "$kept" ] || rm -rf --one-file-system "$folder"
}
[ -n "$folder" ] || folder=$(mktemp -d)
trap finish EXIT
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

step() { echo "packages: $suite: $*"; }
failed() {
  echo "packages: $suite: FAILED: $*" >&2
  [ ! -f "$folder/server.log" ] || tail -n 20 "$folder/server.log" >&2
  exit 1
}

# new_root NAME: a copy of the suite's bare root, with an empty /src.
new_root() {
  step "a bare root"
  make_base "$suite" || failed "it cannot be made"
  root=$folder/$suite.$1
  rm -rf --one-file-system "$root"
  cp -a --reflink=auto "$folder/$suite.base" "$root"
  mkdir "$root/src"
}

# apt-get in the root, which says something only if it fails.
apt() {
  inside "$root" env DEBIAN_FRONTEND=noninteractive apt-get -qq --yes --no-install-recommends \
    -o Dpkg::Use-Pty=0 "$@" >"$folder/apt.log" 2>&1 || { cat "$folder/apt.log"; failed "apt-get $*"; }
}

# start ADDRESS COMMAND...: in the root, until the address is answered.
start() {
  address=$1
  set -m # a group of its own, to be stopped as a whole
  inside "$root" "${@:2}" >"$folder/server.log" 2>&1 &
  started=$!
  set +m
  for _ in $(seq 300); do
    curl --silent --fail --output /dev/null "$address" && return
    kill -0 "$started" 2>/dev/null || break
    sleep 0.2
  done
  failed "it does not start"
}
stop() {
  # unshare holds SIGTERM back; with it, all it has started is killed, though a little later.
  kill -KILL -- "-$started"
  wait "$started" 2>/dev/null || true
  started=""
  for _ in $(seq 150); do
    curl --silent --output /dev/null "$address" || return 0
    sleep 0.2
  done
  failed "it does not end"
}

# upload_triangle URL: a right one, with legs that are random; sets `mesh`, its address.
upload_triangle() {
  local said
  a=$((RANDOM % 999 + 1)) b=$((RANDOM % 999 + 1))
  said=$(printf 'v 0 0 0\nv %s 0 0\nv 0 %s 0\nf 1 2 3\n' $a $b |
    curl --silent --show-error --fail-with-body --data-binary @- "$1/v1/meshes") || failed "$said"
  mesh=$1/v1/meshes/$(jq -r .id <<<"$said")
}
# Its hypotenuse is the distance of two of its vertices.
check_answer() {
  local said
  said=$(curl --silent --show-error --fail-with-body "$mesh/distance?from=v:1&at=v:2&method=exact") ||
    failed "$said"
  jq --exit-status --argjson a "$a" --argjson b "$b" \
    '(.distances[0] / (($a * $a + $b * $b) | sqrt) - 1) | fabs < 1e-9' <<<"$said" >/dev/null ||
    failed "legs $a and $b, and the answer $said"
}
