#!/usr/bin/env bash
# The viewer, built and then used in a real browser against a real server: types, size of
# the bundle, and every gesture of tests/clients/viewer/*.test.mjs. Pictures of what was
# seen are left in VIEWER_PICTURES, if that is set.
# usage: viewer_test.sh GEODESICD MAKE_SAMPLES
set -euo pipefail
if [ $# -ne 2 ]; then
  echo "usage: viewer_test.sh GEODESICD MAKE_SAMPLES" >&2
  exit 2
fi
geodesicd=$(realpath "$1")
make_samples=$(realpath "$2")
here=$(cd "$(dirname "$0")" && pwd)
viewer=$(cd "$here/../../clients/web/viewer" && pwd)
client=$(cd "$here/../../clients/js" && pwd)
for tool in node npm; do
  command -v "$tool" >/dev/null || { echo "skipped: needs $tool"; exit 77; }
done
chromium=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
[ -n "$chromium" ] || { echo "skipped: needs Chromium (Debian's package chromium)"; exit 77; }
unset GEODESICD_URL GEODESICD_CONFIG
export NO_PROXY='*' no_proxy='*'

# npm ci takes everything away first, so what is there and fits the lock file stays.
install() { # FOLDER
  cmp -s "$1/package-lock.json" "$1/node_modules/.lock-installed" && return
  (cd "$1" && npm ci --no-audit --no-fund) || return
  cp "$1/package-lock.json" "$1/node_modules/.lock-installed"
}
install "$viewer"
# The client's types come from the API's document; its sources are bundled as they are.
if [ ! "$client/src/generated/contract.ts" -nt "$here/../../proto/openapi.yaml" ]; then
  install "$client"
  (cd "$client" && npm run generate)
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
(cd "$viewer" && npx vite build --outDir "$folder/dist" --emptyOutDir)
"$make_samples" "$folder/samples" >/dev/null

export GEODESICD=$geodesicd CHROMIUM=$chromium
export VIEWER_DIST=$folder/dist VIEWER_SAMPLES=$folder/samples VIEWER_SOURCES=$viewer
if [ -n "${VIEWER_PICTURES:-}" ]; then mkdir -p "$VIEWER_PICTURES"; fi
# Two at a time, as each has a browser and a server that wait for each other; what one says stays together.
try() { # FILE
  local said status=0
  if [ "$1" = types ]; then said=$(cd "$VIEWER_SOURCES" && npm run check 2>&1) || status=1
  else said=$(node --test "$1" 2>&1) || status=1; fi
  { flock 9; printf '%s\n' "$said"; } 9<"$VIEWER_SAMPLES"
  return $status
}
export -f try
# The large ones first, so that none of them is alone at the end.
# shellcheck disable=SC2016 # the dollar is that of another bash
{ find "$here/viewer" -name '*.test.mjs' -printf '%s %p\n' | sort -nr | cut -d' ' -f2-; echo types; } |
  xargs -d '\n' -n 1 -P 2 bash -c 'try "$1"' bash
