#!/usr/bin/env bash
# The TypeScript client as a whole: its types are generated from openapi.yaml anew, all is
# compiled with strict types, and its tests run against real servers, with the table of
# contract cases and the packed tarball among them. In a copy, so that nothing that is
# built from clients/js at the same time is disturbed.
# usage: js_test.sh GEODESICD [MAKE_SAMPLES]
set -euo pipefail
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
  echo "usage: js_test.sh GEODESICD [MAKE_SAMPLES]" >&2
  exit 2
fi
GEODESICD=$(realpath "$1")
make_samples=$(realpath "${2:-$(dirname "$GEODESICD")/make_samples}")
root=$(cd "$(dirname "$0")/../.." && pwd)
for tool in node npm; do
  command -v "$tool" >/dev/null || { echo "skipped: needs $tool"; exit 77; }
done
if ! node -e 'process.exit(+process.versions.node.split(".")[0] >= 18 ? 0 : 1)'; then
  echo "skipped: needs Node 18, and this is $(node --version)"
  exit 77
fi
# The client talks to this test's servers only, and no proxy comes between.
export NO_PROXY='*' no_proxy='*' NPM_CONFIG_UPDATE_NOTIFIER=false

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/clients/js" "$folder/proto" "$folder/tests/clients"
cp "$root/README.md" "$folder/"
cp "$root/proto/openapi.yaml" "$folder/proto/"
cp "$root/tests/clients/contract_cases.json" "$folder/tests/clients/"
tar -C "$root/clients/js" --exclude=./node_modules --exclude=./dist --exclude=./out \
  --exclude=./src/generated -cf - . | tar -C "$folder/clients/js" -xf -

# What is installed in the tree is used if it is what the lock file says.
modules=$root/clients/js/node_modules
cd "$folder/clients/js"
if [ "$modules/.package-lock.json" -nt package.json ] &&
  [ "$modules/.package-lock.json" -nt "$root/clients/js/package-lock.json" ]; then
  ln -s "$modules" node_modules
elif ! npm ci --prefer-offline --no-audit --no-fund --loglevel=error; then
  [ "${GEODESICD_OFFLINE:-}" = 1 ] || exit 1
  echo "skipped: the client's tools cannot be fetched"
  exit 77
fi

npm run --silent build
npm run --silent build:tests
"$make_samples" "$folder/samples" >/dev/null
export GEODESICD SAMPLES=$folder/samples
# One file after another: each has servers of its own, and machines may be small.
for file in out/*.test.js; do
  echo "== $(basename "$file" .test.js)"
  node --test "$file" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
  grep -E '^(# |ℹ )(pass|fail|skipped) ' "$folder/log"
done
echo "the TypeScript client passes"
