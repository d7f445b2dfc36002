#!/usr/bin/env bash
# Saves the distance from a point to every vertex as little-endian 32-bit floats, in
# the order of the file's vertices (+Inf: unreached), and prints how many there are
# and the greatest. FROM is v:VERTEX, f:FACE,W0,W1 or p:X,Y,Z.
# usage: field.sh ID FROM [OUT.f32] [BASE_URL]
set -euo pipefail
if [ $# -lt 2 ] || [ $# -gt 4 ]; then
  echo "usage: field.sh ID FROM [OUT.f32] [BASE_URL]" >&2
  exit 2
fi
id=$1
from=$2
out=${3:-field.f32}
base=${4:-${GEODESICD_URL:-http://127.0.0.1:8080}}
base=${base%/}

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
if ! curl --silent --show-error --fail-with-body --get \
  --data-urlencode "from=$from" --data format=f32 \
  --dump-header "$scratch/headers" --output "$scratch/body" \
  "$base/v1/meshes/$id/distance"; then
  jq -r '"field.sh: \(.code): \(.detail)"' "$scratch/body" >&2 2>/dev/null || true
  exit 1
fi
# Only a whole field takes the place of an older file.
mv "$scratch/body" "$out"

header() {
  tr -d '\r' <"$scratch/headers" |
    awk -v name="$1" -F ': *' 'tolower($1) == name { value = $2 } END { print value }'
}
max=$(header geo-max)
echo "count $(header geo-shape)"
echo "max ${max:-none}"
