#!/usr/bin/env bash
# Uploads a mesh file (.glb, .gltf with embedded data, .drc, .obj, .ply, .stl) and prints the mesh's id.
# The mesh is called as the file is, unless it has a name already.
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
# Nobody has asked for this name, so no upload is to fail for it: without what the server takes in no
# name (control characters, and what breaks lines or turns their direction), and the last 200 bytes,
# which say the format.
name=$(jq -nr --arg name "${file##*/}" '$name | explode
  | map(select(. > 31 and (. < 127 or . > 159) and (. < 8232 or . > 8238) and (. < 8294 or . > 8297)))
  | implode | until(utf8bytelength <= 200; .[1:]) | sub("^\\s+"; "") | sub("\\s+$"; "") | @uri')
# -T sends the file as it is read, without holding it in memory as --data-binary does.
if ! reply=$(curl --silent --show-error --fail-with-body --request POST \
  --header 'Content-Type: application/octet-stream' --globoff --upload-file "$file" \
  "$base/v1/meshes${name:+?name=$name}"); then
  jq -r '"upload.sh: \(.code): \(.detail)"' <<<"$reply" >&2 2>/dev/null || true
  exit 1
fi
jq -r .id <<<"$reply"
