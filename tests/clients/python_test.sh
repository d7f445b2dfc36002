#!/usr/bin/env bash
# The Python client (clients/python), installed as its users install it, against a real server:
# types and style, the contract's cases, the command, the load tests, the examples, the README's
# snippets and the notebook.
# usage: python_test.sh GEODESICD [MAKE_SAMPLES] [-- PYTEST ARGUMENTS]
set -euo pipefail
if [ $# -lt 1 ]; then
  echo "usage: python_test.sh GEODESICD [MAKE_SAMPLES] [-- PYTEST ARGUMENTS]" >&2
  exit 2
fi
GEODESICD=$(realpath "$1")
shift
MAKE_SAMPLES=$(dirname "$GEODESICD")/make_samples
if [ $# -gt 0 ] && [ "$1" != -- ]; then
  MAKE_SAMPLES=$(realpath "$1")
  shift
fi
if [ "${1:-}" = -- ]; then
  shift
fi
export GEODESICD MAKE_SAMPLES
unset GEODESICD_URL GEODESICD_TOKEN GEODESICD_CONFIG PYTHONPATH
# The client talks to this test's servers only, and no proxy comes between.
export NO_PROXY='*' no_proxy='*' PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=agg
cd "$(dirname "$0")/../../clients/python"

environment=../../build/python
python=$environment/bin/python
mkdir -p ../../build
exec 9>../../build/python.lock
flock 9 # tests run side by side
# What is there already is not fetched again.
if ! cmp --silent requirements-test.txt "$environment/requirements" ||
  ! "$python" -c '' 2>/dev/null; then
  echo "python: installing the tests' requirements" >&2
  rm -rf "$environment"
  /usr/bin/python3 -m venv "$environment"
  "$python" -m pip install --quiet --no-input --disable-pip-version-check \
    --requirement requirements-test.txt >&2
  cp requirements-test.txt "$environment/requirements"
fi
# As users do, from the folder; what it needs was pinned above.
"$python" -m pip install --quiet --no-input --disable-pip-version-check --no-deps --no-warn-script-location \
  --no-build-isolation --force-reinstall . >&2

"$environment/bin/ruff" check --no-cache --quiet .
"$environment/bin/ruff" format --no-cache --check --quiet .
"$environment/bin/mypy" --cache-dir "$environment/mypy" --no-error-summary
"$python" -m pytest "$@"
