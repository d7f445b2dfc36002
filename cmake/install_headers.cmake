# Copies the public headers of core, with the includes of an installed library. Run by
# `cmake --install`, which sets `source`, `include` and `headers`.
cmake_policy(VERSION 3.25)
set(to "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/${include}/geodesic")
foreach(header IN LISTS headers)
  file(READ "${source}/${header}" text)
  string(REGEX MATCHALL "#include \"core/[^\"]+\"" lines "${text}")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "#include \"core/([^\"]+)\"" "\\1" other "${line}")
    if(NOT other IN_LIST headers)
      message(FATAL_ERROR "core/${header} is public and includes core/${other}, which is not. "
                          "Move what it needs, or make that header public in cmake/InstallCore.cmake")
    endif()
  endforeach()
  string(REPLACE "#include \"core/" "#include \"geodesic/" text "${text}")
  file(WRITE "${to}/${header}" "${text}")
endforeach()
list(LENGTH headers count)
message(STATUS "Installed: ${count} headers in ${to}")
