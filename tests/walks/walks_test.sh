#!/usr/bin/env bash
# Follows the three walks of CONTRIBUTING.md: adds a distance method (`straight_line`), a mesh format
# (OFF) and a query (`/normal`) to a copy of the repository, builds the server there, and asks it for
# all three. What each walk led to is kept as a patch beside this file. A walk whose patch no longer
# applies or compiles speaks of code that has changed: then CONTRIBUTING.md leads newcomers astray.
#
#     walks_test.sh BUILD_FOLDER
#
# BUILD_FOLDER has a configured build, whose compiler, generator and libraries are used.
set -euo pipefail
if [ $# -ne 1 ] || [ ! -f "$1/CMakeCache.txt" ]; then
  echo "usage: walks_test.sh BUILD_FOLDER" >&2
  exit 2
fi
source=$(cd "$(dirname "$0")/../.." && pwd -P)
patches=$source/tests/walks
cache=$(cd "$1" && pwd)/CMakeCache.txt
for tool in cmake curl jq patch tar; do
  command -v "$tool" >/dev/null || { echo "skipped: needs $tool"; exit 77; }
done
# The requests are for this test's server only, and no proxy comes between.
unset GEODESICD_CONFIG
export NO_PROXY='*' no_proxy='*'

work=$(mktemp -d)
server=""
clean_up() {
  if [ -n "$server" ]; then
    kill -KILL "$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
  fi
  rm -rf "$work"
}
trap clean_up EXIT

fatal() { # SENTENCE [LOG]
  echo "FAILED: $1"
  [ -z "${2:-}" ] || tail -n 40 "$2"
  exit 1
}

# What git would commit, changes that it has not seen included. Without git, all but what is built.
copy_tree() { # TO
  mkdir "$1"
  if [ "$(git -C "$source" rev-parse --show-toplevel 2>/dev/null)" = "$source" ]; then
    git -C "$source" ls-files -co --exclude-standard -z |
      while IFS= read -r -d '' file; do
        [ ! -e "$source/$file" ] || printf '%s\0' "$file" # one that was deleted is still listed
      done |
      tar -C "$source" -c --null --no-recursion -T - | tar -C "$1" -x
  else
    tar -C "$source" -c --exclude=./.git --exclude=./.cache --exclude=./build \
      --exclude=node_modules . | tar -C "$1" -x
  fi
  # Libraries that were fetched, where there was no home folder for them.
  [ ! -d "$source/.cache" ] || ln -s "$source/.cache" "$1/.cache"
}

walks=("" method format query) # counted from 1
# Lines may have moved, but each change stands between the lines that it stood between.
apply() { # WALK [OPTION...]
  local name=${walks[$1]} log=$work/patch.log
  patch -d "$work/copy" -p1 --fuzz=0 --forward --batch --no-backup-if-mismatch "${@:2}" \
    <"$patches/$name.patch" >"$log" 2>&1 ||
    fatal "CONTRIBUTING.md, walk $1: the code it speaks of has changed. Follow the walk again, mend \
it and tests/walks/$name.patch" "$log"
}

copy_tree "$work/copy"
# Each on its own, for nobody has to go all three.
for walk in 1 2 3; do apply "$walk" --dry-run; done
for walk in 1 2 3; do apply "$walk"; done
"$work/copy/tests/house_test.sh" >"$work/log" ||
  fatal "what the walks add breaks the rules of the rooms" "$work/log"

# Five vertices need no quick code, and it takes three times as long to compile.
options=(-DGEODESIC_TESTS=OFF -DGEODESIC_BENCH=OFF "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG")
for name in CMAKE_C_COMPILER CMAKE_CXX_COMPILER GEODESIC_USE_EMBREE GEODESIC_HTTPLIB_DIR \
  GEODESIC_RPLY_DIR; do
  value=$(sed -n "s/^$name:[A-Z]*=//p" "$cache")
  [ -z "$value" ] || options+=("-D$name=$value")
done
generator=$(sed -n 's/^CMAKE_GENERATOR:INTERNAL=//p' "$cache")
cd "$work/copy"
cmake --preset release -G "$generator" -Wno-dev --log-level=WARNING "${options[@]}" \
  >"$work/log" 2>&1 || fatal "the copy cannot be configured" "$work/log"
cmake --build --preset release --target geodesicd >"$work/log" 2>&1 ||
  fatal "what the walks add no longer compiles. Follow the one that the error is of again, mend \
CONTRIBUTING.md and the patch in tests/walks" "$work/log"

: >"$work/server.out"  # it is read below, maybe before the shell made it for the server
build/release/geodesicd --listen 127.0.0.1:0 --store "$work/store" \
  >"$work/server.out" 2>"$work/server.err" &
server=$!
url=""
for _ in $(seq 300); do
  url=$(sed -n 's/.*listening on \(http:\/\/[^ ]*\).*/\1/p' "$work/server.out" | head -n 1)
  [ -z "$url" ] || break
  kill -0 "$server" 2>/dev/null || fatal "the server ended before it listened" "$work/server.err"
  sleep 0.1
done
[ -n "$url" ] || fatal "the server did not listen within 30 s" "$work/server.err"

failures=0
# Whether jq's FILTER is true of the reply. There, `near` compares arrays of numbers.
expect() { # WHAT FILTER CURL_ARGUMENT...
  # shellcheck disable=SC2016 # the dollars are jq's
  local near='def near($to): length == ($to | length) and
    ([., $to] | transpose | all((.[0] - .[1] | fabs) < 1e-9));'
  if curl --silent --show-error --max-time 60 "${@:3}" >"$work/reply" &&
    jq --exit-status "$near $2" "$work/reply" >/dev/null; then
    echo "ok: $1"
  else
    echo "FAILED: $1"
    head -c 2000 "$work/reply"
    echo
    failures=$((failures + 1))
  fi
}

# A pyramid: its tip is vertex 0, and its base one face of four corners, in red.
cat >"$work/pyramid.off" <<'END'
# x y z
OFF
5 5 8 # vertices, faces, edges
0 0 4
3 0 0
0 3 0
-3 0 0
0 -3 0
3 0 1 2
3 0 2 3
3 0 3 4
3 0 4 1
4 4 3 2 1 255 0 0
END
expect "an OFF file is uploaded" '.format == "off" and .vertices == 5 and .faces == 6' \
  --data-binary "@$work/pyramid.off" "$url/v1/meshes"
id=$(jq --raw-output .id "$work/reply")
sed 's/^3 0 4 1$/3 0 4 5/' "$work/pyramid.off" >"$work/bad.off"
expect "an OFF file with a corner that is no vertex is refused, and its line named" \
  '.status == 422 and .code == "mesh_invalid" and (.detail | contains("line 12"))' \
  --data-binary "@$work/bad.off" "$url/v1/meshes"
head -n 7 "$work/pyramid.off" >"$work/bad.off"
expect "an OFF file that ends too soon is refused" '.status == 422 and .code == "mesh_invalid"' \
  --data-binary "@$work/bad.off" "$url/v1/meshes"

mesh=$url/v1/meshes/$id
expect "/v1/methods has the method" \
  '.methods | any(.name == "straight_line" and (.exact | not) and .parameters == [])' "$url/v1/methods"
expect "distances are those of straight lines in space" \
  '.distances | near([5, 0, 3 * (2 | sqrt), 6, 3 * (2 | sqrt)])' \
  "$mesh/distance?from=v:1&method=straight_line"
expect "the least of several lines counts, with its source's offset" \
  '.labels == [1, 0, 1, 1, 1] and (.distances | near([5, 1, 3 * (2 | sqrt), 0, 3 * (2 | sqrt)]))' \
  --json '{"from": [{"vertex": 1, "offset": 1}, "v:3"], "labels": true, "method": "straight_line"}' \
  "$mesh/distance"
expect "what is farther than max is not reached" '.distances[3] == null and .reached == 4' \
  "$mesh/distance?from=v:1&method=straight_line&max=5.5"
expect "a line goes through the inside" '.distances | near([4])' \
  "$mesh/distance?from=v:0&at=p:0,0,0&method=straight_line"
expect "a path goes along edges" '.reachable and ([.length] | near([8]))' \
  "$mesh/path?from=v:0&to=p:0,0,0&method=straight_line&refine=none"

slope='[12, 12, 9] | map(. / (369 | sqrt))'
expect "the normal of a side" ".normal | near($slope)" "$mesh/normal?at=f:0,0.2,0.3"
expect "the same, asked in JSON" ".normal | near($slope)" \
  --json '{"at": {"face": 0, "bary": [0.2, 0.3, 0.5]}}' "$mesh/normal"
expect "the normal of the base, from below" '.normal | near([0, 0, -1])' \
  "$mesh/normal?at=p:0.5,1,-1"
expect "a normal in a batch" ".status == 200 and (.reply.normal | near($slope))" \
  --data-binary '{"query": "normal", "at": "f:0,0.2,0.3"}' "$mesh/batch"
expect "a parameter that it does not have is refused" \
  '.status == 400 and .code == "unknown_parameter"' "$mesh/normal?at=v:0&from=v:0"

expect "the contract has all three" '
  (.paths["/v1/meshes/{id}/normal"] | has("get") and has("post")) and
  (.components.schemas.Method.enum | index("straight_line")) and
  (.components.schemas.Mesh.properties.format.enum | index("off"))' "$url/openapi.json"

[ "$failures" -eq 0 ] || exit 1
echo "the three walks of CONTRIBUTING.md lead where they say"
