#!/usr/bin/env bash
# systemd_unit.sh BUILD: deploy/systemd/geodesicd.service starts a server that there is: geodesicd
# takes its flags, and systemd, where that is installed, has nothing to say against it.
set -euo pipefail
unit=$(cd "$(dirname "$0")/../.." && pwd)/deploy/systemd/geodesicd.service
geodesicd=$(cd "$1" && pwd)/geodesicd

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
flags=$(sed -n 's|^ExecStart=/usr/local/bin/geodesicd ||p' "$unit")
[ -n "$flags" ] || { echo "FAILED: no ExecStart"; exit 1; }
read -ra words <<<"${flags//\/var\/lib\/geodesicd/$folder}"
"$geodesicd" "${words[@]}" --check-config

if command -v systemd-analyze >/dev/null; then
  sed "s|/usr/local/bin/geodesicd|$geodesicd|" "$unit" >"$folder/geodesicd.service"
  said=$(SYSTEMD_LOG_LEVEL=warning systemd-analyze verify --man=no "$folder/geodesicd.service" 2>&1) || true
  [ -z "$said" ] || { echo "FAILED: $said"; exit 1; }
fi
