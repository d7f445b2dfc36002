// The header of a PLY file, made fit for rply.
#pragma once

#include <string>
#include <string_view>

#include "core/base/error.h"

namespace geodesic::proto {

struct PlyHeader {
  std::string lines;      // what rply is to read: plain lines up to `end_header`
  std::string_view data;  // what follows in the file
  bool is_text = false;
  bool has_strips = false;  // an element `tristrips`
};

[[nodiscard]] bool is_ply(std::string_view text);

// Comments are left out, lines end in \n, have the number of words that is theirs and
// none that is too long; elements after the last of `vertex` and `face` are left out too.
// In a text, single whole numbers become `double`: rply would refuse the red of 128.0 or
// 300 that scripts write, at which nobody looks.
// What rply 1.1.4 makes of other headers: a comment without text takes the next line with
// it, a word of more than 255 bytes is printed into too small a buffer, and where words
// are lacking those of the data are taken.
// Errors: mesh_invalid, naming the line.
[[nodiscard]] Result<PlyHeader> clean_ply_header(std::string_view text);

}  // namespace geodesic::proto
