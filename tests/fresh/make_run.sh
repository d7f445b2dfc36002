#!/usr/bin/env bash
# Does in a fresh root what a newcomer does: `make run`, paste the printed curl line, do as the
# README says to three readers (readers.py), press Ctrl-C. Fails unless all of that works and the
# server is gone afterwards. Run in the repository's folder, with PORT set to a free port.
set -euo pipefail
# Job control: `make run` gets a process group of its own, as in a terminal, and
# Ctrl-C's signal is not ignored.
set -m

log=$(mktemp)
make run >"$log" 2>&1 &
run=$!
line=
while [ -z "$line" ]; do
  sleep 0.5
  line=$(sed -n "s/^ *try  *\(curl .*\)/\1/p" "$log")
  if [ -z "$line" ] && ! kill -0 "$run" 2>/dev/null; then
    cat "$log"
    echo "make_run: ended before it printed an address" >&2
    exit 1
  fi
done
grep -B 3 -A 1 '^ *try ' "$log"

status=0
echo "+ $line"
reply=$(eval "$line --silent --show-error --fail-with-body") || status=1
echo "${reply:0:300}"
jq --exit-status '.reachable and .length > 0 and (.points | length) >= 2' <<<"$reply" >/dev/null ||
  status=1

# The README's first pages, from a fresh clone.
python3 tests/fresh/readers.py "$PORT" || status=1

kill -INT -- "-$run"
wait "$run" 2>/dev/null || true
if curl --silent --max-time 2 --output /dev/null "http://127.0.0.1:$PORT/livez"; then
  echo "make_run: the server outlived Ctrl-C" >&2
  status=1
fi
grep -q '^run: stopped' "$log" || { tail -n 5 "$log"; status=1; }
exit $status
