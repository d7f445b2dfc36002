# geodesic_precompile(TARGET HEADER...)
#
# Parses headers that most files of TARGET include: once for all of them, and not
# once for each. For example
#     geodesic_precompile(geodesic_proto <nlohmann/json.hpp>)
# A file must still include what it uses: the debug preset, which `make lint`
# reads, builds without precompiled headers.
function(geodesic_precompile target)
  target_precompile_headers(${target} PRIVATE ${ARGN})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # ccache reads preprocessed text, which must name the header that was used.
    target_compile_options(${target} PRIVATE -fpch-preprocess)
  elseif(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    # The same header must give the same bytes whenever it is compiled.
    target_compile_options(${target} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")
  endif()
endfunction()

# What most files of the engine and of its tests include: from the standard library, and
# tl/expected, of which `Result` is made.
set(GEODESIC_STANDARD_HEADERS <algorithm> <array> <cmath> <cstdint> <functional> <limits> <memory>
  <optional> <span> <string> <tuple> <unordered_map> <utility> <vector> <tl/expected.hpp>)

# geodesic_unite(TARGET)
#
# Compiles the files of TARGET by eights, so that what they all include is parsed and
# instantiated once for eight of them. The debug preset does not.
option(GEODESIC_UNITY "Compile files with heavy headers by eights" ON)
function(geodesic_unite target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${GEODESIC_UNITY})
endfunction()
