#include "proto/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include "proto/text_tokens.h"

namespace geodesic::proto {
namespace {

constexpr std::size_t most_elements = 64;
constexpr std::size_t most_properties = 1024;  // of one element
constexpr std::size_t most_ply_name_bytes = 128;

// Both families of names are in use.
std::optional<PlyType> type_of(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> names{{
      {"char", PlyType::int8},
      {"uchar", PlyType::uint8},
      {"short", PlyType::int16},
      {"ushort", PlyType::uint16},
      {"int", PlyType::int32},
      {"uint", PlyType::uint32},
      {"float", PlyType::float32},
      {"double", PlyType::float64},
      {"int8", PlyType::int8},
      {"uint8", PlyType::uint8},
      {"int16", PlyType::int16},
      {"uint16", PlyType::uint16},
      {"int32", PlyType::int32},
      {"uint32", PlyType::uint32},
      {"float32", PlyType::float32},
      {"float64", PlyType::float64},
  }};
  const auto* found = std::ranges::find(names, name, [](const auto& pair) { return pair.first; });
  if (found == names.end()) return std::nullopt;
  return found->second;
}

class HeaderReader {
 public:
  explicit HeaderReader(std::string_view text) : text_(text), tokens_(text) {}

  Result<PlyHeader> run() {
    tokens_.next_line();  // "ply"
    bool has_format = false;
    for (;;) {
      const auto keyword = tokens_.word_on_line();
      if (keyword == "end_header") break;
      Result<void> read;
      if (keyword == "format") {
        read = format();
        has_format = true;
      } else if (keyword == "element") {
        read = element();
      } else if (keyword == "property") {
        read = property();
      } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
        read = invalid("this is no line of a PLY header.");
      }
      if (!read) return fail(read.error());
      if (!tokens_.next_line()) {
        return fail(ErrorCode::mesh_invalid, "The PLY header has no `end_header`.");
      }
    }
    if (!has_format) return fail(ErrorCode::mesh_invalid, "The PLY header has no `format`.");
    tokens_.next_line();
    header_.size = text_.size() - tokens_.rest().size();
    if (const auto claimed = check_claims(); !claimed) return fail(claimed.error());
    return std::move(header_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> invalid(const std::string& what) const {
    return fail(ErrorCode::mesh_invalid, tokens_.line() + ": " + what);
  }

  Result<void> format() {
    using Encoding = PlyHeader::Encoding;
    const auto name = tokens_.word_on_line();
    if (name == "ascii") {
      header_.encoding = Encoding::text;
    } else if (name == "binary_little_endian") {
      header_.encoding = Encoding::little_endian;
    } else if (name == "binary_big_endian") {
      header_.encoding = Encoding::big_endian;
    } else {
      return invalid("the format is none that PLY knows.");
    }
    return {};
  }

  Result<void> element() {
    if (header_.elements.size() == most_elements) return invalid("there are too many elements.");
    PlyElement element;
    element.name = std::string(tokens_.word_on_line().substr(0, most_ply_name_bytes));
    const auto count = whole_of_word(tokens_.word_on_line());
    if (element.name.empty() || !count || *count < 0) {
      return invalid("an element has a name and a count.");
    }
    element.count = static_cast<std::uint64_t>(*count);
    header_.elements.push_back(std::move(element));
    return {};
  }

  Result<void> property() {
    if (header_.elements.empty()) return invalid("a property belongs to an element.");
    auto& properties = header_.elements.back().properties;
    if (properties.size() == most_properties) return invalid("there are too many properties.");
    PlyProperty property;
    auto word = tokens_.word_on_line();
    if (word == "list") {
      property.count = type_of(tokens_.word_on_line());
      if (!property.count || !is_integer(*property.count)) {
        return invalid("the length of a list is of an integer type.");
      }
      word = tokens_.word_on_line();
    }
    const auto type = type_of(word);
    property.name = std::string(tokens_.word_on_line().substr(0, most_ply_name_bytes));
    if (!type || property.name.empty()) return invalid("a property has a type and a name.");
    property.type = *type;
    properties.push_back(std::move(property));
    return {};
  }

  // Before memory is taken for anything. A word of a text takes two bytes with the
  // blank after it, but for the last.
  [[nodiscard]] Result<void> check_claims() const {
    std::uint64_t left = text_.size() - header_.size;
    for (const PlyElement& element : header_.elements) {
      std::uint64_t each = element.least_bytes();
      if (header_.encoding == PlyHeader::Encoding::text) each = 2 * element.properties.size();
      if (element.properties.empty()) {
        if (element.count == 0) continue;
        return fail(ErrorCode::mesh_invalid,
                    "The PLY element " + printable(element.name) + " has no properties.");
      }
      if (element.count > (left + 1) / each) {
        return fail(ErrorCode::mesh_invalid,
                    "The PLY element " + printable(element.name) + " claims " +
                        std::to_string(element.count) + " of at least " + std::to_string(each) +
                        " bytes, but " + std::to_string(left) + " bytes are left.");
      }
      left -= std::min(left, element.count * each);
    }
    return {};
  }

  static std::string printable(std::string text) {
    for (char& c : text) {
      if (c < 0x20 || c > 0x7E) c = '?';
    }
    return text;
  }

  std::string_view text_;
  TextTokens tokens_;
  PlyHeader header_;
};

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::int32:
    case PlyType::uint32:
    case PlyType::float32:
      return 4;
    case PlyType::float64:
      return 8;
  }
  return 0;
}

bool is_integer(PlyType type) { return type != PlyType::float32 && type != PlyType::float64; }

std::uint64_t PlyElement::least_bytes() const {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += size_of(property.count.value_or(property.type));
  return bytes;
}

bool is_ply(std::string_view text) {
  if (!text.starts_with("ply")) return false;
  text.remove_prefix(3);
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  return text.starts_with('\n') || text.starts_with('\r');
}

Result<PlyHeader> read_ply_header(std::string_view text) { return HeaderReader(text).run(); }

}  // namespace geodesic::proto
