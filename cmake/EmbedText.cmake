# cmake -DINPUT=FILE -DOUTPUT=FILE.cpp -P EmbedText.cmake
# Writes a source file with geodesic::server::openapi_document(), the text of INPUT.
# In pieces, because compilers bound the length of one string literal.
file(READ ${INPUT} text)
string(LENGTH "${text}" length)
set(literals "")
set(begin 0)
while(begin LESS length)
  string(SUBSTRING "${text}" ${begin} 8000 piece)
  string(APPEND literals "    R\"openapi(${piece})openapi\"\n")
  math(EXPR begin "${begin} + 8000")
endwhile()
file(WRITE ${OUTPUT} "#include \"server/openapi_document.h\"

namespace geodesic::server {

std::string_view openapi_document() {
  return
${literals}      ;
}

}  // namespace geodesic::server
")
