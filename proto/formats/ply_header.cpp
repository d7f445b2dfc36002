#include "proto/formats/ply_header.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "proto/mesh/text_tokens.h"

namespace geodesic::proto {
namespace {

constexpr std::size_t kMostHeaderBytes = 16384;  // rply takes about twenty times that
constexpr std::size_t kMostWordBytes = 255;      // rply's WORDSIZE, less the end

bool is_integer_type(std::string_view name) {
  static constexpr std::string_view kNames[] = {"char",  "uchar",  "short", "ushort",
                                                "int",   "uint",   "int8",  "uint8",
                                                "int16", "uint16", "int32", "uint32"};
  return std::ranges::count(kNames, name) != 0;
}

class HeaderCleaner {
 public:
  explicit HeaderCleaner(std::string_view text) : tokens_(text) {}

  Result<PlyHeader> run() {
    tokens_.next_line();  // "ply"
    for (;;) {
      const auto keyword = tokens_.word_on_line();
      if (keyword == "end_header") break;
      if (const auto read = line(keyword); !read) return fail(read.error());
      if (header_.lines.size() > kMostHeaderBytes) return invalid("the header is too long.");
      if (!tokens_.next_line()) {
        return fail(ErrorCode::mesh_invalid, "The PLY header has no `end_header`.");
      }
    }
    if (header_.lines.empty()) {
      return fail(ErrorCode::mesh_invalid, "The PLY header has no `format`.");
    }
    tokens_.next_line();
    header_.data = tokens_.rest();
    header_.lines.resize(wanted_);
    header_.lines = "ply\n" + header_.lines + "end_header\n";
    return std::move(header_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> invalid(const std::string& what) const {
    return fail(ErrorCode::mesh_invalid, tokens_.line() + ": " + what);
  }

  Result<void> line(std::string_view keyword) {
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return {};
    if (header_.lines.empty() != (keyword == "format")) {
      return invalid("a PLY header begins with `format`, which is there once.");
    }
    const auto first = tokens_.word_on_line();
    std::vector<std::string_view> words{keyword, first};
    if (keyword == "format") {
      header_.is_text = first == "ascii";
      words.emplace_back("1.0");
    } else if (keyword == "element") {
      words.push_back(tokens_.word_on_line());
      if (whole_of_word(words.back()).value_or(-1) < 0) {
        return invalid("an element has a name and a count.");
      }
      is_wanted_ = first == "vertex" || first == "face";
      if (is_wanted_ && header_.lines.find("\nelement " + std::string(first) + " ") < wanted_) {
        return invalid("an element is there twice.");
      }
      header_.has_strips |= first == "tristrips";
    } else if (keyword == "property") {
      const int more = first == "list" ? 3 : 1;
      for (int i = 0; i < more; ++i) words.push_back(tokens_.word_on_line());
      if (header_.is_text && is_integer_type(first)) words[1] = "double";
    } else {
      return invalid("this is no line of a PLY header.");
    }
    for (const std::string_view& word : words) {
      if (word.empty()) return invalid("a word is lacking here.");
      if (word.size() > kMostWordBytes || word.find('\0') != std::string_view::npos) {
        return invalid("a word is too long, or has a zero byte.");
      }
      // Where it looks for a type, rply would step over it.
      if (word == "comment" || word == "obj_info") return invalid("a comment has its own line.");
      header_.lines += word;
      header_.lines += &word == &words.back() ? '\n' : ' ';
    }
    if (is_wanted_ || keyword == "format") wanted_ = header_.lines.size();
    return {};
  }

  TextTokens tokens_;
  PlyHeader header_;
  bool is_wanted_ = false;  // the element that properties belong to now
  std::size_t wanted_ = 0;  // bytes of lines up to the end of the last one wanted
};

}  // namespace

bool is_ply(std::string_view text) {
  if (!text.starts_with("ply")) return false;
  text.remove_prefix(3);
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  return text.starts_with('\n') || text.starts_with('\r');
}

Result<PlyHeader> clean_ply_header(std::string_view text) { return HeaderCleaner(text).run(); }

}  // namespace geodesic::proto
