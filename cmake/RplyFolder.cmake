# Finds rply, which reads PLY files: Debian 13's package, or on Debian 12, which has
# none, the source that scripts/fetch_library fetched. Dependencies.cmake includes this,
# and `make setup` runs it as a script,
#     cmake -P cmake/RplyFolder.cmake
# which prints the folder found, or fails.
#
# Sets RPLY_INCLUDE_DIR, empty when there is none, and RPLY_SOURCE, rply.c where it is
# for us to compile.
cmake_policy(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/FetchedFolders.cmake)

geodesic_fetched_folders(rply _rply_folders)
# In this order: what the user names, the system, what was fetched.
list(PREPEND _rply_folders
  "${GEODESIC_RPLY_DIR}" "$ENV{GEODESIC_RPLY_DIR}" /usr/local/include /usr/include)
list(REMOVE_ITEM _rply_folders "")

set(RPLY_INCLUDE_DIR "")
set(RPLY_SOURCE "")
foreach(_folder IN LISTS _rply_folders)
  if(EXISTS "${_folder}/rply.h")
    get_filename_component(RPLY_INCLUDE_DIR "${_folder}" ABSOLUTE)
    if(EXISTS "${RPLY_INCLUDE_DIR}/rply.c")
      set(RPLY_SOURCE "${RPLY_INCLUDE_DIR}/rply.c")
    endif()
    break()
  endif()
endforeach()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  if(RPLY_INCLUDE_DIR STREQUAL "")
    message(FATAL_ERROR "no rply.h in: ${_rply_folders}")
  endif()
  message("${RPLY_INCLUDE_DIR}")
endif()
