# cmake -DFUNCTION=NAME -DINPUT=FILE -DOUTPUT=FILE.cpp -P EmbedText.cmake
# Writes a source file in which geodesic::server::NAME() is the text of INPUT: in
# pieces, because compilers bound the length of one string literal. Clang warns of
# their sum, which it takes.
file(READ ${INPUT} text)
string(LENGTH "${text}" length)
set(literals "")
set(begin 0)
while(begin LESS length)
  string(SUBSTRING "${text}" ${begin} 8000 piece)
  string(APPEND literals "    R\"embedded(${piece})embedded\"\n")
  math(EXPR begin "${begin} + 8000")
endwhile()
file(WRITE ${OUTPUT} "#include \"server/routes/embedded_text.h\"

#ifdef __clang__
#pragma clang diagnostic ignored \"-Woverlength-strings\"
#endif

namespace geodesic::server {

std::string_view ${FUNCTION}() {
  return
${literals}      ;
}

}  // namespace geodesic::server
")
