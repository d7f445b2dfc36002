#!/usr/bin/env bash
# What holds on every mesh, on two of each kind drawn anew: no distance is below the straight line in
# space, no upper bound below the truth, and all methods reach the same vertices.
#
# usage: family_test.sh GEODESIC_BENCH; GEODESICD_SEED=NUMBER has a failure again
set -euo pipefail

seed=${GEODESICD_SEED:-$((RANDOM * 32768 + RANDOM))}
echo "GEODESICD_SEED=$seed"
"$1" --family "$seed" --quick
