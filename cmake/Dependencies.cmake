# Every library from outside that core does not need, found in one place. `make setup` installs
# them. Where Debian 12 and 13 differ, the difference ends here.
find_package(Threads REQUIRED)
# Debian's own, which has Debian's PyYAML: the contract becomes JSON in the build.
find_program(GEODESIC_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto SSL)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(CURL 7.87 REQUIRED)  # the first to sign x-amz-content-sha256
find_package(pugixml REQUIRED)
find_package(prometheus-cpp REQUIRED CONFIG)
find_package(PkgConfig REQUIRED)
pkg_check_modules(seccomp REQUIRED IMPORTED_TARGET libseccomp)
find_package(meshoptimizer REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)  # used as a header
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)

# geodesic_draco: the shared library where there is one, the static one otherwise.
find_package(draco REQUIRED)
add_library(geodesic_draco INTERFACE)
if(TARGET draco::draco)
  target_link_libraries(geodesic_draco INTERFACE draco::draco)
else()
  target_link_libraries(geodesic_draco INTERFACE draco::draco_static)
endif()

set(GEODESIC_HTTPLIB_DIR "" CACHE PATH "Folder of httplib.h, looked in first")
include(HttplibFolder)
if(NOT HTTPLIB_INCLUDE_DIR)
  message(FATAL_ERROR "No httplib.h of at least 0.41; `make setup` fetches one")
endif()
message(STATUS "cpp-httplib ${HTTPLIB_VERSION}: ${HTTPLIB_INCLUDE_DIR}")

# geodesic_rply: an installed library, or compiled here, without our warnings.
set(GEODESIC_RPLY_DIR "" CACHE PATH "Folder of rply.h and rply.c, looked in first")
include(RplyFolder)
if(NOT RPLY_INCLUDE_DIR)
  message(FATAL_ERROR "No rply.h; `make setup` installs or fetches it")
endif()
message(STATUS "rply: ${RPLY_INCLUDE_DIR}")
if(RPLY_SOURCE)
  add_library(geodesic_rply STATIC ${RPLY_SOURCE})
  if(GEODESIC_SANITIZE)
    target_compile_options(geodesic_rply PRIVATE -fsanitize=${GEODESIC_SANITIZE})
  endif()
  if(GEODESIC_FUZZ)  # libFuzzer sees into it
    target_compile_options(geodesic_rply PRIVATE -fsanitize=fuzzer-no-link)
  endif()
else()
  find_library(RPLY_LIBRARY rply REQUIRED)
  add_library(geodesic_rply INTERFACE)
  target_link_libraries(geodesic_rply INTERFACE ${RPLY_LIBRARY})
endif()
target_include_directories(geodesic_rply SYSTEM INTERFACE ${RPLY_INCLUDE_DIR})

if(GEODESIC_TESTS)
  find_package(doctest REQUIRED)
endif()
if(GEODESIC_BENCH)
  find_package(benchmark REQUIRED)
endif()
