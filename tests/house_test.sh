#!/usr/bin/env bash
# The house keeps its rooms: every file is in one, each #include is an arrow of docs/rooms.txt,
# and the types of a library from outside stay in the one file that includes it.
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
  'proto/|server/|httplib|nlohmann|spdlog|tiny_gltf|draco|CLI|openssl|iostream|fstream|mutex' core
# Core starts no threads and has no clock. Who waits in it for another thread lets others go first,
# and notices when that takes long.
waiting=$(including 'thread>|chrono>' core)
if [ "$waiting" != core/base/team.cpp ]; then
  echo "FAILED: threads and clocks belong in core/base/team.cpp: $waiting"
  status=1
fi
expect_none 'proto reaches into the server' 'server/|httplib|spdlog|CLI|thread|mutex' proto
# The element of a temporary dangles once the loop begins: only the temporary itself would live on.
dangling=$(grep -rnE 'for \([^;]* : [a-z_:]+\(.*\)(\["|\[[0-9]|\.(at|front|back|value)\()' \
  --include='*.h' --include='*.cpp' core proto server clients tests --exclude-dir=node_modules)
if [ -n "$dangling" ]; then
  echo "FAILED: a loop goes over an element of a temporary: $dangling"
  status=1
fi
expect_none 'the product reaches into the tests' 'tests/|doctest' core proto server

# Every #include of ours against the table, and every room against its pages.
rooms() {
  local sources
  mapfile -t sources < <(find core proto server -name '*.h' -o -name '*.cpp' | sort)
  # shellcheck disable=SC2016 # the dollars are awk's
  awk -v table=docs/rooms.txt '
    function room_of(path, part) {
      return split(path, part, "/") == 3 ? part[1] "/" part[2] : ""
    }
    function failed(sentence) {
      print "FAILED: " sentence
      status = 1
    }
    BEGIN {
      FS = " *[|] *"
      while ((getline <table) > 0) {
        if ($0 ~ /^(#|$)/) continue
        if ($1 in place) failed($1 " stands twice in " table ".")
        place[$1] = ++count
        name[count] = $1
        n = split($3, others, " ")
        for (i = 1; i <= n; ++i) {
          if (!(others[i] in place)) {
            failed(table ": " $1 " may include only rooms that stand above it, and " others[i] \
                   " does not. Move the row, or the file that needs it, so that arrows make no ring.")
          }
          arrow[$1, others[i]] = 1
        }
      }
      FS = " "
      for (i = 1; i < ARGC; ++i) {
        from = room_of(ARGV[i])
        if (from == "") {
          failed(ARGV[i] " is in no room. Move it into the folder whose purpose in " table " it serves.")
        } else if (!(from in place)) {
          failed(ARGV[i] " is in a room that " table " does not have. Add a row, or move the file.")
        }
        ++files[from]
      }
    }
    FNR == 1 { from = room_of(FILENAME) }
    from in place && match($0, /^ *# *include *"(core|proto|server)\/[^"]*"/) {
      to = $0
      sub(/^[^"]*"/, "", to)
      sub(/".*/, "", to)
      path = to
      to = room_of(path)
      if (to == from) next
      if ((from, to) in arrow) {
        used[from, to] = 1
      } else {
        failed(FILENAME " includes " path ", and " table " has no arrow from " from " to " to \
               ". Move what is needed into a room that both may include, or, if the arrow is right," \
               " add it to the row of " from ".")
      }
    }
    END {
      for (i = 1; i <= count; ++i) {
        room = name[i]
        if (files[room] < 4 || files[room] > 26) {
          failed(room " has " (files[room] + 0) " files, and a room has 4 to 26. Split it, or give its" \
                 " files to its neighbours.")
        }
        includes = users = ""
        for (j = 1; j <= count; ++j) {
          if ((room, name[j]) in arrow) {
            includes = includes (includes == "" ? "" : ", ") "`" name[j] "`"
            if (!((room, name[j]) in used)) {
              failed(table ": no file of " room " includes anything of " name[j] \
                     " any more. Take the arrow out.")
            }
          }
          if ((name[j], room) in arrow) users = users (users == "" ? "" : ", ") "`" name[j] "`"
        }
        page = room "/README.md"
        text = ""
        lines = 0
        while ((getline line <page) > 0) {
          text = text (text == "" ? "" : " ") line
          ++lines
        }
        close(page)
        if (lines == 0) failed(page " is missing: say what the room is for and where to start.")
        if (lines > 40) failed(page " has " lines " lines, and may have 40.")
        may = "May include: " (includes == "" ? "no other room" : includes) "."
        if (lines && !index(text, may)) failed(page " should say as " table " does: " may)
        by = "Used by: " (users == "" ? "no other room" : users) "."
        if (lines && !index(text, by)) failed(page " should say as " table " does: " by)
      }
      exit status
    }' "${sources[@]}"
}
rooms || status=1

# Tests stand in rooms of the same names.
for folder in tests/core/*/ tests/proto/*/ tests/server/*/; do
  room=${folder#tests/}
  if ! grep -q "^${room%/} |" docs/rooms.txt; then
    echo "FAILED: $folder mirrors no room of docs/rooms.txt. Name it as the room it tests."
    status=1
  fi
done

# A code without a row would be told as an internal error.
codes=$(sed -nE 's/^inline constexpr ErrorCode (ErrorCode::[a-z_]+).*/\1/p' core/base/error.h
  sed -nE 's/.*static constexpr ErrorCode ([a-z_]+).*/InputCode::\1/p' proto/wire/input_codes.h
  sed -nE 's/.*static constexpr ErrorCode ([a-z_]+).*/ServiceCode::\1/p' server/base/service_codes.h)
for code in $codes; do
  if ! grep -q "Row{$code," server/http/problem.cpp; then
    echo "FAILED: $code has no row in server/http/problem.cpp. Give it a status and a title."
    status=1
  fi
done

# Whoever clones the repository gets the modes that git has.
while IFS= read -r file; do
  if [ "$(head -c 2 "$file" 2>/dev/null | tr -d '\0')" = '#!' ]; then
    echo "FAILED: $file begins with #! and cannot be run. git update-index --chmod=+x $file"
    status=1
  fi
done < <(git ls-files --stage 2>/dev/null | sed -n 's/^100644 [^\t]*\t//p' | grep -vE '\.(md|json|cpp|h|ts|css|html|svg|png)$')

[ $status -eq 0 ] && echo "every include is in its room"
exit $status
