#!/usr/bin/env bash
# Uploads a mesh file (.glb, .gltf with embedded data, .drc, .obj, .ply, .stl) and prints the mesh's id.
# usage: upload.sh FILE [BASE_URL]
set -euo pipefail
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
  echo "usage: upload.sh FILE [BASE_URL]" >&2
  exit 2
fi
file=$1
base=${2:-${GEODESICD_URL:-http://127.0.0.1:8080}}
base=${base%/}

if [ ! -f "$file" ] || [ ! -r "$file" ]; then
  echo "upload.sh: $file cannot be read" >&2
  exit 1
fi
# -T sends the file as it is read, without holding it in memory as --data-binary does.
if ! reply=$(curl --silent --show-error --fail-with-body --request POST \
  --header 'Content-Type: application/octet-stream' --globoff --upload-file "$file" "$base/v1/meshes"); then
  jq -r '"upload.sh: \(.code): \(.detail)"' <<<"$reply" >&2 2>/dev/null || true
  exit 1
fi
jq -r .id <<<"$reply"
