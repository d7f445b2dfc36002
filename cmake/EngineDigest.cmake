# Writes OUTPUT, the source of server/routes/engine_digest.h: a digest of all that decides which bytes
# the program answers. ROOT: the tree; BUILD: a text that names compiler, flags, options and
# libraries.
set(digests "${BUILD}\n")
foreach(folder core proto server cmake .)
  if(folder STREQUAL .)
    set(files CMakeLists.txt)
  else()
    file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/${folder}/*.cpp ${ROOT}/${folder}/*.h
         ${ROOT}/${folder}/*.cmake ${ROOT}/${folder}/CMakeLists.txt)
  endif()
  list(SORT files)
  foreach(file IN LISTS files)
    file(SHA256 ${ROOT}/${file} digest)
    string(APPEND digests "${digest} ${file}\n")
  endforeach()
endforeach()
string(SHA256 digest "${digests}")
string(SUBSTRING ${digest} 0 32 digest)
file(WRITE ${OUTPUT} "#include \"server/routes/engine_digest.h\"

namespace geodesic::server {

std::string_view engine_digest() { return \"${digest}\"; }

}  // namespace geodesic::server
")
