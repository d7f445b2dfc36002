# What every target of ours is compiled with. Libraries from outside are SYSTEM
# includes, so their warnings are not ours.
set(GEODESIC_SANITIZE "" CACHE STRING "Sanitizers, such as address,undefined or thread")

add_library(geodesic_options INTERFACE)
target_compile_options(geodesic_options INTERFACE
  -Wall -Wextra -Wpedantic
  # Results must not depend on whether the compiler finds a fused multiply-add.
  -ffp-contract=off)
target_include_directories(geodesic_options INTERFACE ${CMAKE_SOURCE_DIR})
if(NOT GEODESIC_ONLY_CORE)  # a library meets compilers that were not there when it was written
  target_compile_options(geodesic_options INTERFACE -Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # Both are false at `string = "literal"` with -O3: GCC's bug 105329, fixed in 13.
  target_compile_options(geodesic_options INTERFACE -Wno-restrict -Wno-stringop-overflow)
endif()

if(GEODESIC_SANITIZE)
  target_compile_options(geodesic_options INTERFACE
    -fsanitize=${GEODESIC_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(geodesic_options INTERFACE -fsanitize=${GEODESIC_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC's manual: instrumentation gives these warnings false positives. The
    # release build still has them.
    target_compile_options(geodesic_options INTERFACE
      -Wno-maybe-uninitialized -Wno-restrict -Wno-stringop-overflow)
  endif()
endif()
