#!/usr/bin/env bash
# core as a library, as others get it: installed, found by CMake and by pkg-config, and the examples
# built outside of this tree. Twice: from the build that is tested, and from one of core alone,
# without Embree and without any other library of the service. Both say the same.
#
#     library_test.sh BUILD_FOLDER
set -euo pipefail
source=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

run() {
  if ! "$@" >"$work/log" 2>&1; then
    echo "FAILED: $*"
    tail -n 40 "$work/log"
    exit 1
  fi
}

run cmake --install "$build" --component geodesic --prefix "$work/with/prefix"

without=()
for package in draco nlohmann_json spdlog CLI11 OpenSSL ZLIB PNG CURL pugixml prometheus-cpp \
  PkgConfig meshoptimizer embree doctest benchmark; do
  without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done
# At -O1, for to compile it takes longer than the few questions below.
run cmake -S "$source" -B "$build/only_core" -G Ninja -DGEODESIC_ONLY_CORE=ON \
  "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG" -DGEODESIC_USE_EMBREE=OFF "${without[@]}"
run cmake --build "$build/only_core"
run cmake --install "$build/only_core" --prefix "$work/without/prefix"

# Four faces about a tip, which comes first.
cat >"$work/pyramid.obj" <<'END'
v 0 0 1
v 1 0 0
v 0 1 0
v -1 0 0
v 0 -1 -3
f 1 2 3
f 1/1 3/1 4/1
f 1//1 4//1 5//1
f 1 5 2
END

for way in with without; do
  cd "$work/$way"
  cp -r "$source/examples" .
  run cmake -S examples -B built -G Ninja "-DCMAKE_PREFIX_PATH=$work/$way/prefix"
  run cmake --build built
  {
    built/distances_and_a_path "$work/pyramid.obj"
    built/queries_in_threads
    built/cancel_with_progress 600
  } >answers
  # One that is stopped at once, and a file that is not there.
  status=0
  built/cancel_with_progress 0 >stopped || status=$?
  if [ "$status" -ne 2 ] || ! grep -q '^stopped: the computation was cancelled' stopped; then
    echo "FAILED: cancel_with_progress 0 gave $status and:"
    cat stopped
    exit 1
  fi
  ! built/distances_and_a_path nothing.obj 2>/dev/null ||
    { echo "FAILED: distances_and_a_path found nothing.obj"; exit 1; }

  config=$(find prefix -name geodesic.pc -printf '%h')
  flags=$(PKG_CONFIG_PATH=$PWD/$config pkg-config --cflags --libs geodesic)
  # shellcheck disable=SC2086 # flags are words
  run g++ -std=c++20 examples/distances_and_a_path.cpp $flags -o by_pkg_config
  run diff <(./by_pkg_config "$work/pyramid.obj") <(built/distances_and_a_path "$work/pyramid.obj")
done
run diff "$work/with/answers" "$work/without/answers"
cat "$work/with/answers"

# From the tip to the lowest corner it is one edge.
grep -q '^vertex 5 is 4.123105626 away' "$work/with/answers" ||
  { echo "FAILED: the distance of the lowest corner is the square root of 17"; exit 1; }
if ldd "$work/without/built/distances_and_a_path" | grep -qE 'embree|draco|ssl|curl|spdlog'; then
  echo "FAILED: the engine alone links a library that it does not need"
  exit 1
fi
echo "the library is found, built and run from outside, with Embree and without"
