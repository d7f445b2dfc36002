#!/usr/bin/env bash
# in_tools.sh SCRIPT BUILD: runs a script of this folder with the Python that
# scripts/fetch_contract_tools installs. Without these tools it fails: a contract that
# nobody checks is none. GEODESICD_OFFLINE=1 says that there is no network, and skips it.
set -uo pipefail
cd "$(dirname "$0")" || exit 1
if ! python=$(../../scripts/fetch_contract_tools); then
  [ "${GEODESICD_OFFLINE:-}" = 1 ] || exit 1
  echo "skipped: the tools for $1 cannot be fetched"
  exit 77
fi
exec "$python" "$@"
