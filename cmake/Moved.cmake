# Headers that were moved are found by their old names too, until includes say the new ones.
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/moved.txt rows)
foreach(row IN LISTS rows)
  string(REPLACE " " ";" row "${row}")
  list(GET row 0 old)
  list(GET row 1 new)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/moved/${old} CONTENT "#include \"${new}\"\n" @ONLY)
endforeach()
include_directories(${CMAKE_BINARY_DIR}/moved ${CMAKE_BINARY_DIR}/moved/tests/proto)
