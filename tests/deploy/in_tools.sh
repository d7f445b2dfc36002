#!/usr/bin/env bash
# in_tools.sh SCRIPT GEODESICD: runs a script of this folder with the Python and the programs that
# scripts/fetch_deploy_tools installs. Without them it fails. GEODESICD_OFFLINE=1 says that there is no
# network, and skips it.
set -uo pipefail
cd "$(dirname "$0")" || exit 1
if ! tools=$(../../scripts/fetch_deploy_tools); then
  [ "${GEODESICD_OFFLINE:-}" = 1 ] || exit 1
  echo "skipped: the tools for $1 cannot be fetched"
  exit 77
fi
PATH=$tools:$PATH exec "$tools/python" "$@"
