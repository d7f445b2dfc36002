#!/usr/bin/env bash
# The house keeps its rooms: dependencies point one way, and the types of a library
# from outside stay in the one file that includes it.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
status=0

# Files under the given folders that include something matching the pattern.
including() { # PATTERN FOLDER...
  local pattern=$1
  shift
  grep -rlE "^ *# *include *[<\"]($pattern)" --include='*.h' --include='*.cpp' "$@" | sort
}
expect_one() { # LIBRARY PATTERN
  local files
  files=$(including "$2" core proto server)
  if [ "$(wc -l <<<"$files")" -ne 1 ] || [ "${files##*.}" != cpp ]; then
    echo "FAILED: $1 belongs in one .cpp, and is included by: $files"
    status=1
  fi
}
expect_none() { # WHAT PATTERN FOLDER...
  local what=$1 files
  shift
  files=$(including "$@")
  if [ -n "$files" ]; then
    echo "FAILED: $what: $files"
    status=1
  fi
}

expect_one cpp-httplib 'httplib\.h'
expect_one tinygltf 'tiny_gltf\.h'
expect_one Draco 'draco/'
expect_one rply 'rply\.h|rplyfile\.h'
expect_one libseccomp 'seccomp\.h'
expect_none 'core reaches out of its room' \
  'proto/|server/|httplib|nlohmann|spdlog|tiny_gltf|draco|CLI|openssl|iostream|fstream|thread|mutex|chrono' core
expect_none 'proto reaches into the server' 'server/|httplib|spdlog|CLI|thread|mutex' proto
expect_none 'the product reaches into the tests' 'tests/|doctest' core proto server

[ $status -eq 0 ] && echo "every include is in its room"
exit $status
