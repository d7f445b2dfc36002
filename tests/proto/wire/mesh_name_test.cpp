#include "proto/wire/mesh_name.h"

#include <doctest/doctest.h>

#include <string>

using namespace geodesic;
using namespace geodesic::proto;

TEST_CASE("AMeshNameIsAFewBytesOfTextOnOneLine") {
  CHECK(is_mesh_name("bunny.glb"));
  CHECK(is_mesh_name("Größe 3 / left"));
  CHECK(is_mesh_name(std::string(200, 'a')));
  CHECK_FALSE(is_mesh_name(""));
  CHECK_FALSE(is_mesh_name(std::string(201, 'a')));
  CHECK_FALSE(is_mesh_name("two\nlines"));
  CHECK_FALSE(is_mesh_name("\x7f"));
  CHECK_FALSE(is_mesh_name("\xff"));
  // Each control character and mark of direction, anywhere; their neighbours may be in a name.
  for (const char* control :
       {"\u0080", "\u0085", "\u009f", "\u2028", "\u2029", "\u202a", "\u202e", "\u2066", "\u2069"}) {
    CHECK_FALSE(is_mesh_name(control));
    CHECK_FALSE(is_mesh_name(std::string("a") + control + "b"));
  }
  for (const char* neighbour : {"\u00a0", "\u2027", "\u202f", "\u2065", "\u206a", "\u200d"}) {
    CHECK(is_mesh_name(std::string("a") + neighbour + "b"));
  }
  CHECK_FALSE(is_mesh_name("cut \xc3"));
}
