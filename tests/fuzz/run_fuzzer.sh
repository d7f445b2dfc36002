#!/usr/bin/env bash
# Runs one fuzzer from seeds that make_fuzz_seeds makes and from all past findings:
#
#     run_fuzzer.sh FUZZER MAKE_FUZZ_SEEDS SECONDS [CORPUS]
#
# What it learns goes into the folder CORPUS, if one is named. What breaks it is written
# beside the fuzzer, as NAME-crash-... Exit status 0 if nothing does.
set -euo pipefail
fuzzer=$1 make_seeds=$2 seconds=$3
name=$(basename "$fuzzer")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$make_seeds" "$folder/seeds"
learnt=${4:-$folder/learnt}
mkdir -p "$learnt"
corpora=("$learnt" "$folder/seeds/${name#fuzz_}")
findings=$(dirname "$0")/findings/${name#fuzz_}
[ ! -d "$findings" ] || corpora+=("$findings")
"$fuzzer" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=4096 -print_final_stats=1 \
  -artifact_prefix="$(dirname "$fuzzer")/$name-" "${corpora[@]}"
