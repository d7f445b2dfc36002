#!/usr/bin/env bash
# in_simpy.sh SCRIPT ARGUMENT...: runs a script of this folder with the Python that scripts/fetch_simpy
# makes. Without it the script fails; GEODESICD_OFFLINE=1 says that there is no network, and skips it.
set -uo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if ! python=$("$here/../../scripts/fetch_simpy"); then
  [ "${GEODESICD_OFFLINE:-}" = 1 ] || exit 1
  echo "skipped: SimPy cannot be fetched"
  exit 77
fi
script=$here/$1
shift
exec "$python" "$script" "$@"
