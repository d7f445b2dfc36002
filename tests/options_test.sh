#!/usr/bin/env bash
# The README's table of options is the one that the program prints.
#
#     options_test.sh GEODESICD
set -uo pipefail
readme="$(dirname "$0")/../README.md"
if difference=$(diff <("$1" --print-config-table) \
                     <(sed -n '/^| flag | environment |/,/^$/p' "$readme" | grep '^|')); then
  echo "README.md has the options as they are"
else
  echo "FAILED: README.md is not what --print-config-table prints:"
  echo "$difference"
  exit 1
fi
