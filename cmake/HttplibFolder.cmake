# Finds cpp-httplib's header, at least 0.41: older ones run an unread body as the
# next request and do not bound chunked bodies, and Debian 12's and 13's packages
# are older. The one place that knows where to look and which version will do:
# Dependencies.cmake includes it, and `make setup` runs it as a script,
#     cmake -P cmake/HttplibFolder.cmake
# which prints the folder found, or fails.
#
# Sets HTTPLIB_INCLUDE_DIR and HTTPLIB_VERSION; empty when there is none.
cmake_policy(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/FetchedFolders.cmake)

geodesic_fetched_folders(httplib _httplib_folders)
# In this order: what the user names, what was fetched, the system.
list(PREPEND _httplib_folders "${GEODESIC_HTTPLIB_DIR}" "$ENV{GEODESIC_HTTPLIB_DIR}")
list(APPEND _httplib_folders /usr/local/include /usr/include)
list(REMOVE_ITEM _httplib_folders "")

set(HTTPLIB_INCLUDE_DIR "")
set(HTTPLIB_VERSION "")
foreach(_folder IN LISTS _httplib_folders)
  if(NOT EXISTS "${_folder}/httplib.h")
    continue()
  endif()
  file(STRINGS "${_folder}/httplib.h" _line REGEX "#define CPPHTTPLIB_VERSION \"" LIMIT_COUNT 1)
  string(REGEX REPLACE ".*\"([0-9.]+)\".*" "\\1" _version "${_line}")
  if(_version VERSION_GREATER_EQUAL 0.41)
    get_filename_component(HTTPLIB_INCLUDE_DIR "${_folder}" ABSOLUTE)
    set(HTTPLIB_VERSION "${_version}")
    break()
  endif()
endforeach()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  if(HTTPLIB_INCLUDE_DIR STREQUAL "")
    message(FATAL_ERROR "no httplib.h of at least 0.41 in: ${_httplib_folders}")
  endif()
  message("${HTTPLIB_INCLUDE_DIR} (cpp-httplib ${HTTPLIB_VERSION})")
endif()
