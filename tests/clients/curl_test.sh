#!/usr/bin/env bash
# The curl scripts against a server of their own: a plane's distance field and
# diagonal, known in closed form, an error, an orderly end, and what they can ask of the
# contract's table of cases.
# usage: curl_test.sh GEODESICD MAKE_SAMPLES
set -euo pipefail
if [ $# -ne 2 ]; then
  echo "usage: curl_test.sh GEODESICD MAKE_SAMPLES" >&2
  exit 2
fi
geodesicd=$1
make_samples=$2
scripts=$(cd "$(dirname "$0")/../../clients/curl" && pwd)
for tool in curl jq python3; do
  command -v "$tool" >/dev/null || { echo "skipped: needs $tool"; exit 77; }
done
# The scripts talk to this test's server only, and no proxy comes between.
unset GEODESICD_URL GEODESICD_CONFIG
export NO_PROXY='*' no_proxy='*'

folder=$(mktemp -d)
server=""
clean_up() {
  if [ -n "$server" ]; then
    kill -KILL "$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
  fi
  rm -rf "$folder"
}
trap clean_up EXIT

failures=0
check() { # WHAT COMMAND...
  local what=$1
  shift
  if "$@"; then
    echo "ok: $what"
  else
    echo "FAILED: $what"
    failures=$((failures + 1))
  fi
}
# Whether two numbers differ by at most 1e-5 (1e-3 %) of the second.
close_to() {
  awk -v a="$1" -v b="$2" 'BEGIN {
    if (a !~ /^[0-9.]+(e[-+]?[0-9]+)?$/) exit 1
    d = a - b; if (d < 0) d = -d
    exit !(d <= 1e-5 * b)
  }'
}
fatal() {
  echo "FAILED: $1"
  sed 's/^/  server: /' "$folder/server.err" 2>/dev/null || true
  exit 1
}

"$make_samples" "$folder/samples" >/dev/null || fatal "make_samples"
: >"$folder/server.out"  # it is read below, maybe before the shell made it for the server
"$geodesicd" --listen 127.0.0.1:0 --store "$folder/store" \
  >"$folder/server.out" 2>"$folder/server.err" &
server=$!

url=""
for _ in $(seq 300); do
  url=$(sed -n 's/.*listening on \(http:\/\/[^ ]*\).*/\1/p' "$folder/server.out" | head -n 1)
  [ -z "$url" ] || break
  kill -0 "$server" 2>/dev/null || fatal "the server ended before it listened"
  sleep 0.1
done
[ -n "$url" ] || fatal "the server did not listen within 30 s"
echo "server at $url"

plane=$folder/samples/plane.glb
id=$("$scripts/upload.sh" "$plane" "$url") || fatal "upload.sh plane.glb"
check "upload.sh prints the SHA-256 of the file" \
  test "$id" = "$(sha256sum "$plane" | cut -d ' ' -f 1)"
check "a second upload prints the same id" \
  test "$(GEODESICD_URL=$url "$scripts/upload.sh" "$plane")" = "$id"

diagonal=140.00714267493640 # 99 * sqrt(2)
field=$folder/field.f32
said=$("$scripts/field.sh" "$id" v:0 "$field" "$url") || fatal "field.sh from v:0"
check "the field of 100x100 vertices has 40000 bytes" test "$(wc -c <"$field")" -eq 40000
check "field.sh prints the count 10000" test "$(sed -n 's/^count //p' <<<"$said")" = 10000
max=$(sed -n 's/^max //p' <<<"$said")
check "field.sh prints the diagonal as the greatest distance ($max)" close_to "$max" "$diagonal"
check "the first value of the field is 0" \
  test "$(od -An -v -t f4 -N 4 "$field" | tr -d ' ')" = 0
last=$(od -An -v -t f4 -j 39996 -N 4 "$field" | tr -d ' ')
check "the last value of the field is the diagonal ($last)" close_to "$last" "$diagonal"

said=$("$scripts/path.sh" "$id" v:0 v:9999 "$url") || fatal "path.sh from v:0 to v:9999"
length=$(sed -n 's/^length //p' <<<"$said")
points=$(sed -n 's/^points //p' <<<"$said")
check "the path's length is the diagonal ($length)" close_to "$length" "$diagonal"
check "the path has at least two points ($points)" test "${points:-0}" -ge 2
check "path.sh prints as many points as it says" test "$(sed 1,2d <<<"$said" | wc -l)" = "$points"
ends=$(sed -n '3p;$p' <<<"$said" | awk 'NF == 3 { print } NF != 3 { exit 1 }') ||
  fatal "path.sh prints points as x y z"
travelled=$(awk 'NR == 1 { x = $1; y = $2; z = $3 }
  END { printf "%.9g", sqrt(($1 - x) ^ 2 + ($2 - y) ^ 2 + ($3 - z) ^ 2) }' <<<"$ends")
check "the path's ends are a diagonal apart ($travelled)" close_to "$travelled" "$diagonal"

unknown=$(printf '%064d' 0)
for call in "field.sh $unknown v:0 $folder/none.f32" "path.sh $unknown v:0 v:1"; do
  read -r -a words <<<"$call"
  status=0
  "$scripts/${words[0]}" "${words[@]:1}" "$url" >"$folder/out" 2>"$folder/err" || status=$?
  check "${words[0]} of an unknown mesh exits with 1 ($status)" test "$status" -eq 1
  check "${words[0]} of an unknown mesh names mesh_unknown" grep -q mesh_unknown "$folder/err"
  check "${words[0]} of an unknown mesh prints no result" test ! -s "$folder/out"
done
check "field.sh leaves no file after an error" test ! -e "$folder/none.f32"
echo "this is no mesh" >"$folder/words.glb"
status=0
"$scripts/upload.sh" "$folder/words.glb" "$url" >"$folder/out" 2>"$folder/err" || status=$?
check "upload.sh of a file that is no mesh exits with 1 ($status)" test "$status" -eq 1
check "upload.sh of a file that is no mesh names format_unknown" \
  grep -q format_unknown "$folder/err"

kill -TERM "$server"
for _ in $(seq 300); do
  kill -0 "$server" 2>/dev/null || break
  sleep 0.1
done
kill -KILL "$server" 2>/dev/null || true # one that still runs fails the check below
status=0
wait "$server" || status=$?
server=""
check "the server ends with 0 after SIGTERM ($status)" test "$status" -eq 0

check "the contract's cases and the names of files" \
  python3 "$(dirname "$0")/curl_cases.py" "$geodesicd" "$folder/samples"

if [ "$failures" -gt 0 ]; then
  echo "$failures failed"
  exit 1
fi
echo "all passed"
