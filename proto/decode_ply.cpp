#include "proto/decode_ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "proto/one_part.h"
#include "proto/ply_header.h"
#include "proto/polygon_soup.h"
#include "proto/text_tokens.h"

namespace geodesic::proto {
namespace {

// The values of a text one by one; nothing at what is no number, or at the end. What
// nobody uses, such as a normal, may be infinite or NaN in a file that is whole.
class TextValues {
 public:
  explicit TextValues(std::string_view text) : tokens_(text) {}
  std::optional<double> next(PlyType /*type*/) {
    const std::string_view word = tokens_.word();
    if (const auto value = finite_of_word(word)) return value;
    double other = 0;
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, other);
    if (word.empty() || error != std::errc() || stop != end) return std::nullopt;
    return other;  // not finite
  }

 private:
  TextTokens tokens_;
};

// The same of a binary file.
class BinaryValues {
 public:
  BinaryValues(std::string_view bytes, bool is_swapped) : rest_(bytes), is_swapped_(is_swapped) {}

  std::optional<double> next(PlyType type) {
    switch (type) {
      case PlyType::int8:
        return value<std::int8_t>();
      case PlyType::uint8:
        return value<std::uint8_t>();
      case PlyType::int16:
        return value<std::int16_t>();
      case PlyType::uint16:
        return value<std::uint16_t>();
      case PlyType::int32:
        return value<std::int32_t>();
      case PlyType::uint32:
        return value<std::uint32_t>();
      case PlyType::float32:
        return value<float>();
      case PlyType::float64:
        return value<double>();
    }
    return std::nullopt;
  }

 private:
  template <class T>
  std::optional<double> value() {
    if (rest_.size() < sizeof(T)) return std::nullopt;
    std::array<char, sizeof(T)> bytes{};
    std::copy_n(rest_.begin(), sizeof(T), bytes.begin());
    rest_.remove_prefix(sizeof(T));
    if (is_swapped_) std::ranges::reverse(bytes);
    return static_cast<double>(std::bit_cast<T>(bytes));
  }

  std::string_view rest_;
  bool is_swapped_;
};

// Which property is which coordinate, or the list of corners; -1: none.
struct Roles {
  std::array<std::ptrdiff_t, 3> xyz{-1, -1, -1};
  std::ptrdiff_t corners = -1;
};

Roles roles_of(const PlyElement& element) {
  Roles roles;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    const auto at = static_cast<std::ptrdiff_t>(i);
    if (element.name == "vertex" && !property.count) {
      if (property.name == "x") roles.xyz[0] = at;
      if (property.name == "y") roles.xyz[1] = at;
      if (property.name == "z") roles.xyz[2] = at;
    }
    if (element.name == "face" && property.count &&
        (property.name == "vertex_indices" || property.name == "vertex_index")) {
      roles.corners = at;
    }
  }
  return roles;
}

template <class Values>
class PlyReader {
 public:
  PlyReader(Values values, const DecodeLimits& limits) : values_(values), soup_(limits) {}

  Result<TriangleSoup> run(const PlyHeader& header, Findings& findings) {
    // Nothing after the last element of these two is of use.
    std::size_t last = 0;
    for (std::size_t i = 0; i < header.elements.size(); ++i) {
      const std::string& name = header.elements[i].name;
      if (name == "vertex" || name == "face") last = i + 1;
      if (name == "tristrips") {
        findings.add("strips_left_out", "element tristrips", "is not read");
      }
    }
    for (std::size_t i = 0; i < last; ++i) {
      if (const auto read = element(header.elements[i]); !read) return fail(read.error());
    }
    return std::move(soup_).triangulated(findings);
  }

 private:
  static tl::unexpected<Error> invalid(const PlyElement& element, std::uint64_t number,
                                       const std::string& what) {
    const bool known = element.name == "vertex" || element.name == "face";
    return fail(ErrorCode::mesh_invalid, (known ? element.name : "PLY element") + " " +
                                             std::to_string(number) + ": " + what);
  }

  Result<void> element(const PlyElement& element) {
    const Roles roles = roles_of(element);
    if (element.name == "vertex" && std::ranges::count(roles.xyz, -1) != 0) {
      return fail(ErrorCode::mesh_invalid, "The PLY element vertex lacks x, y or z.");
    }
    const bool is_face = element.name == "face";
    if (is_face && roles.corners < 0) {
      return fail(ErrorCode::mesh_invalid, "The PLY element face has no list vertex_indices.");
    }
    for (std::uint64_t number = 0; number < element.count; ++number) {
      Vec3 position{};
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        const auto at = static_cast<std::ptrdiff_t>(i);
        if (property.count) {
          if (const auto read = list(element, number, property, at == roles.corners); !read) {
            return read;
          }
          continue;
        }
        const auto value = values_.next(property.type);
        const bool is_wanted = std::ranges::count(roles.xyz, at) != 0;
        if (!value) {
          return invalid(element, number,
                         is_wanted ? "the data end, or a coordinate is no finite number."
                                   : "the data end, or a property is no number.");
        }
        if (is_wanted && !std::isfinite(*value)) {
          return invalid(element, number, "a coordinate is no finite number.");
        }
        if (at == roles.xyz[0]) position.x = *value;
        if (at == roles.xyz[1]) position.y = *value;
        if (at == roles.xyz[2]) position.z = *value;
      }
      if (element.name == "vertex") {
        if (auto added = soup_.add_vertex(position); !added) return added;
      } else if (is_face) {
        if (auto added = face(element, number); !added) return added;
      }
    }
    return {};
  }

  Result<void> list(const PlyElement& element, std::uint64_t number, const PlyProperty& property,
                    bool is_corners) {
    const auto length = values_.next(*property.count);
    if (!length || !(*length >= 0 && *length <= 1e15) || *length != std::floor(*length)) {
      return invalid(element, number, "the data end, or a list has no length.");
    }
    if (is_corners) corners_.clear();
    // Of any length: each value is there before there is memory for it.
    for (double left = *length; left > 0; --left) {
      const auto value = values_.next(property.type);
      if (!value) return invalid(element, number, "the data end within a list.");
      if (!is_corners) continue;
      if (!(*value >= 0 && *value <= std::numeric_limits<std::uint32_t>::max()) ||
          *value != std::floor(*value)) {
        return invalid(element, number, "a corner names no vertex.");
      }
      corners_.push_back(static_cast<std::uint32_t>(*value));
    }
    return {};
  }

  Result<void> face(const PlyElement& element, std::uint64_t number) {
    if (corners_.size() < 3) {
      return invalid(element, number, "it has " + std::to_string(corners_.size()) + " corners.");
    }
    return soup_.add_face(corners_);
  }

  Values values_;
  PolygonSoup soup_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Result<DecodedMesh> decode_ply(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  const auto header = read_ply_header(text);
  if (!header) return fail(header.error());
  using Encoding = PlyHeader::Encoding;
  const std::string_view data = text.substr(header->size);
  const Encoding native =
      std::endian::native == std::endian::little ? Encoding::little_endian : Encoding::big_endian;
  Findings findings;
  auto soup = header->encoding == Encoding::text
                  ? PlyReader(TextValues(data), limits).run(*header, findings)
                  : PlyReader(BinaryValues(data, header->encoding != native), limits)
                        .run(*header, findings);
  if (!soup) return fail(std::move(soup.error()));
  DecodedMesh mesh = mesh_of_one_part(MeshFormat::ply, std::move(*soup));
  mesh.findings = findings.done();
  return mesh;
}

}  // namespace geodesic::proto
