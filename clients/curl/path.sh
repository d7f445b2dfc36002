#!/usr/bin/env bash
# Prints a geodesic path: its length, its number of points, then one "x y z" a line.
# An unreachable target prints "length inf" and "points 0".
# FROM and TO are v:VERTEX, f:FACE,W0,W1 or p:X,Y,Z.
# usage: path.sh ID FROM TO [BASE_URL]
set -euo pipefail
if [ $# -lt 3 ] || [ $# -gt 4 ]; then
  echo "usage: path.sh ID FROM TO [BASE_URL]" >&2
  exit 2
fi
id=$1
from=$2
to=$3
base=${4:-${GEODESICD_URL:-http://127.0.0.1:8080}}
base=${base%/}

if ! reply=$(curl --silent --show-error --fail-with-body --get \
  --data-urlencode "from=$from" --data-urlencode "to=$to" --data format=json \
  "$base/v1/meshes/$id/path"); then
  jq -r '"path.sh: \(.code): \(.detail)"' <<<"$reply" >&2 2>/dev/null || true
  exit 1
fi
jq -r '"length \(.length // "inf")", "points \(.points | length)",
       (.points[].xyz | map(tostring) | join(" "))' <<<"$reply"
