# geodesic_fetched_folders(NAME OUT)
#
# Sets OUT to the folders where scripts/fetch_library puts the library NAME: the user's
# cache folder, and the repository's own (where there is no home folder to write to).
function(geodesic_fetched_folders name out)
  set(folders "")
  if(NOT "$ENV{XDG_CACHE_HOME}" STREQUAL "")
    list(APPEND folders "$ENV{XDG_CACHE_HOME}/geodesicd/${name}")
  elseif(NOT "$ENV{HOME}" STREQUAL "")
    list(APPEND folders "$ENV{HOME}/.cache/geodesicd/${name}")
  endif()
  list(APPEND folders "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../.cache/geodesicd/${name}")
  set(${out} "${folders}" PARENT_SCOPE)
endfunction()
