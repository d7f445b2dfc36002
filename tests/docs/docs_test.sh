#!/usr/bin/env bash
# The documentation site as a whole: it builds, its links lead somewhere, what its pages tell to do
# works, and a browser shows them whole, light and without other hosts. Pictures of pages are left in
# DOCS_PICTURES, if that is set.
# usage: docs_test.sh GEODESICD MAKE_SAMPLES
set -euo pipefail
if [ $# -ne 2 ]; then
  echo "usage: docs_test.sh GEODESICD MAKE_SAMPLES" >&2
  exit 2
fi
geodesicd=$(realpath "$1")
make_samples=$(realpath "$2")
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
for tool in node npm; do
  command -v "$tool" >/dev/null || { echo "skipped: needs $tool"; exit 77; }
done
chromium=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
[ -n "$chromium" ] || { echo "skipped: needs Chromium (Debian's package chromium)"; exit 77; }
unset GEODESICD_URL GEODESICD_CONFIG GEODESICD_TOKEN PYTHONPATH
export NO_PROXY='*' no_proxy='*' PYTHONDONTWRITEBYTECODE=1

if ! "$root/scripts/build_docs"; then
  [ "${GEODESICD_OFFLINE:-}" = 1 ] || exit 1
  echo "skipped: the site's generator cannot be fetched"
  exit 77
fi

# The browser and its tools are the viewer's; the JavaScript client is bundled as it is.
install() { # FOLDER
  cmp -s "$1/package-lock.json" "$1/node_modules/.lock-installed" && return
  (cd "$1" && npm ci --no-audit --no-fund --silent) || return
  cp "$1/package-lock.json" "$1/node_modules/.lock-installed"
}
install "$root/clients/web/viewer"
if [ ! "$root/clients/js/src/generated/contract.ts" -nt "$root/proto/openapi.yaml" ]; then
  install "$root/clients/js"
  (cd "$root/clients/js" && npm run --silent generate)
fi
client=$root/build/docs_client
folder=$(mktemp -d)
site=
trap '[ -z "$site" ] || kill "$site"; rm -rf "$folder"' EXIT
"$make_samples" "$folder/samples" >/dev/null
mkdir "$folder/viewer"
echo '<!doctype html><title>viewer</title>' >"$folder/viewer/index.html"
export GEODESICD=$geodesicd CHROMIUM=$chromium VIEWER_SOURCES=$root/clients/web/viewer
export VIEWER_DIST=$folder/viewer VIEWER_SAMPLES=$folder/samples
export DOCS_SITE=$root/build/docs DOCS_PYTHON=$client/bin/python
if [ -n "${DOCS_PICTURES:-}" ]; then mkdir -p "$DOCS_PICTURES"; fi

# To look at every page takes about as long as all else together, and waits as often: both at once.
node --test "$here/site.test.mjs" >"$folder/site.log" 2>&1 &
site=$!
status=0
"$here/check_links.py" "$root/build/docs" "$root/proto/openapi.yaml" || status=1

# The Python client as its users install it, in an environment of its own.
exec 8>"$client.lock"
flock 8
"$client/bin/python" -c 'import httpx, numpy, rich' 2>/dev/null || {
  /usr/bin/python3 -m venv "$client"
  "$client/bin/python" -m pip install --quiet --no-input --disable-pip-version-check hatchling==1.33.0
  "$client/bin/python" -m pip install --quiet --no-input --disable-pip-version-check "$root/clients/python"
}
"$client/bin/python" -m pip install --quiet --no-input --disable-pip-version-check --no-deps \
  --no-build-isolation --force-reinstall "$root/clients/python"
"$here/run_pages.py" "$(dirname "$geodesicd")" "$client/bin/python" || status=1
"$here/nginx_config.py" "$(dirname "$geodesicd")" || status=1
for file in "$here"/*.test.mjs; do
  [ "$file" = "$here/site.test.mjs" ] || node --test "$file" || status=1
done
wait "$site" || status=1
site=
cat "$folder/site.log"
exit $status
