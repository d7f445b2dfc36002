# How tests and fuzzers are declared, so that `make test` and `make fuzz` find
# them, build no more than a pass needs, and count them.
#
# ctest labels: `doctest` (run again under ASan and UBSan) and `tsan` (concurrency;
# run again under TSan). The targets doctest_executables and tsan_executables
# build what has that label.
add_custom_target(doctest_executables)
add_custom_target(tsan_executables)

# geodesic_add_doctest(TARGET [TSAN] [RELEASE_ONLY])
#
# Makes ctest run the executable TARGET, which has tests written with doctest, as a
# whole. TSAN: it tests concurrency. RELEASE_ONLY: it measures how well the code does
# that other tests go through, and no sanitizer looks at it.
function(geodesic_add_doctest target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "TSAN;RELEASE_ONLY" "" "")
  target_link_libraries(${target} PRIVATE doctest_main)
  geodesic_precompile(${target} <doctest/doctest.h> <random> ${GEODESIC_STANDARD_HEADERS})
  # What is tested is in the libraries; tests themselves are compiled more often than run, and
  # doctest names the line that failed.
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1$<SEMICOLON>-g0>)
  # At -O1 GCC sees strings overflow that do not, where tests put them together: 12 at array-bounds
  # alone, 14 more widely. What is tested keeps these warnings.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-array-bounds)
    if(CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
      target_compile_options(${target} PRIVATE -Wno-stringop-overflow -Wno-stringop-overread
        -Wno-restrict -Wno-maybe-uninitialized)
    endif()
  endif()
  # A little before the TIMEOUT below, by which ctest would kill it without a word: at SIGTERM
  # doctest names the test case that is running.
  add_test(NAME ${target} COMMAND timeout --kill-after=20 1400 $<TARGET_FILE:${target}>)
  set(labels measure)
  if(NOT arg_RELEASE_ONLY)
    add_dependencies(doctest_executables ${target})
    set(labels doctest)
  endif()
  if(arg_TSAN)
    add_dependencies(tsan_executables ${target})
    list(APPEND labels tsan)
  endif()
  set_tests_properties(${target} PROPERTIES LABELS "${labels}" TIMEOUT 1500)
endfunction()

# geodesic_add_script_test(NAME COMMAND...)
#
# A test in bash or Python: it passes with exit status 0, and was skipped with 77.
function(geodesic_add_script_test name)
  add_test(NAME ${name} COMMAND ${ARGN})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 600)
endfunction()

# geodesic_add_fuzzer(TARGET)
#
# The executable TARGET, whose name begins with `fuzz_`, has an
# LLVMFuzzerTestOneInput. Only in the fuzz preset, where everything is compiled
# with coverage already. ctest runs it for a few seconds.
function(geodesic_add_fuzzer target)
  if(NOT target MATCHES "^fuzz_")
    message(FATAL_ERROR "${target}: `make fuzz` runs what begins with fuzz_")
  endif()
  target_link_libraries(${target} PRIVATE geodesic_options)
  target_link_options(${target} PRIVATE -fsanitize=fuzzer)
  add_test(NAME ${target}
           COMMAND ${CMAKE_SOURCE_DIR}/tests/fuzz/run_fuzzer.sh $<TARGET_FILE:${target}>
                   $<TARGET_FILE:make_fuzz_seeds> 3)
  set_tests_properties(${target} PROPERTIES TIMEOUT 300)
endfunction()
