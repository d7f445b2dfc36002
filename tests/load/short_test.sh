#!/usr/bin/env bash
# The load scripts, each for a second or two and with bounds so wide that no busy
# machine misses them: that they work, and that nothing is wrong by far.
#
#     short_test.sh BUILD
set -uo pipefail
cd "$(dirname "$0")" || exit 1
build=$1
status=0
python3 slow_clients.py "$build" --seconds 2 --idle 200 --slow 40 --patience 0 --slack 30 || status=1
python3 overload.py "$build" --seconds 3 --slack 30 || status=1
python3 throughput.py "$build" --seconds 1 --rounds 1 --slack 30 || status=1
python3 decoder_overhead.py "$build" --rounds 8 --large 200 --slack 30 || status=1
python3 soak.py "$build" --seconds 6 --slack 3 || status=1
python3 slow_downloads.py "$build" --clients 30 --megabytes 8 || status=1
python3 table_slots.py "$build" --rounds 2 --rows 8 --slack 30 || status=1
python3 memory_mix.py "$build" --side 200 --seconds 8 --query-mib 12 --compute-mib 64 --caches-mib 48 --deadline-ms 20000 || status=1
python3 stops.py "$build" --side 300 --rounds 1 || status=1
exit $status
