#include "proto/formats/decode_stl.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "proto/mesh/one_part.h"
#include "proto/mesh/text_tokens.h"

namespace geodesic::proto {
namespace {

constexpr std::size_t kBinaryHeader = 80;
constexpr std::size_t kBinaryPreamble = 84;
constexpr std::size_t kBinaryFacet = 50;  // normal, three vertices, 16 bits of anything
constexpr std::size_t kBinaryNormal = 12;

template <class T>
T little_endian(const std::byte* at) {
  static_assert(std::endian::native == std::endian::little);
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::uint64_t facets_claimed(std::span<const std::byte> bytes) {
  return little_endian<std::uint32_t>(bytes.data() + kBinaryHeader);
}

bool is_binary_stl(std::span<const std::byte> bytes) {
  return bytes.size() >= kBinaryPreamble &&
         bytes.size() == kBinaryPreamble + kBinaryFacet * facets_claimed(bytes);
}

bool is_word(std::string_view word, std::string_view lower_case) {
  return std::ranges::equal(word, lower_case, [](char c, char lower) {
    return (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) == lower;
  });
}

// Room for one more facet, or why there is none.
Result<void> check_room(std::uint64_t facets, const DecodeLimits& limits) {
  const auto most_vertices = std::min<std::uint64_t>(limits.max_vertices, 0xFFFFFFFF);
  if (3 * facets > most_vertices) {
    return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.",
                      most_vertices, 3 * facets);
  }
  if (facets > limits.max_faces) {
    return fail_limit(ErrorCode::too_many_faces, "The mesh has too many faces.", limits.max_faces,
                      facets);
  }
  return {};
}

Result<TriangleSoup> read_binary(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const std::uint64_t facets = facets_claimed(bytes);
  if (auto room = check_room(facets, limits); !room) return fail(room.error());
  TriangleSoup soup;
  soup.positions.resize(3 * facets);
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    const std::byte* at = bytes.data() + kBinaryPreamble + i / 3 * kBinaryFacet + kBinaryNormal +
                          i % 3 * 3 * sizeof(float);
    const Vec3 p{little_endian<float>(at), little_endian<float>(at + 4),
                 little_endian<float>(at + 8)};
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      return fail(ErrorCode::mesh_invalid, "Facet " + std::to_string(i / 3) + ": vertex " +
                                               std::to_string(i % 3) + " is not finite.");
    }
    soup.positions[i] = p;
  }
  return soup;
}

class TextReader {
 public:
  TextReader(std::string_view text, const DecodeLimits& limits) : tokens_(text), limits_(limits) {}

  // Several solids may follow one another; their names are not looked at.
  Result<TriangleSoup> run() {
    for (auto word = tokens_.word(); !word.empty(); word = tokens_.word()) {
      if (is_word(word, "solid") || is_word(word, "endsolid")) {
        tokens_.next_line();
      } else if (is_word(word, "facet")) {
        if (const auto read = facet(); !read) return fail(read.error());
      } else {
        return invalid("`facet` or `endsolid` is wanted here.");
      }
    }
    return std::move(soup_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> invalid(const std::string& what) const {
    return fail(ErrorCode::mesh_invalid, tokens_.line() + ": " + what);
  }

  bool next_are(std::initializer_list<std::string_view> words) {
    return std::ranges::all_of(
        words, [&](std::string_view word) { return is_word(tokens_.word(), word); });
  }

  Result<void> facet() {
    if (auto room = check_room(soup_.positions.size() / 3 + 1, limits_); !room) return room;
    if (!next_are({"normal"})) return invalid("`normal` is wanted here.");
    // Some exporters write nan into it; nobody looks at it.
    for (int i = 0; i < 3; ++i) tokens_.word();
    if (!next_are({"outer", "loop"})) return invalid("`outer loop` is wanted here.");
    for (int i = 0; i < 3; ++i) {
      if (!next_are({"vertex"})) return invalid("`vertex` is wanted here, three times a facet.");
      const auto x = finite_of_word(tokens_.word());
      const auto y = finite_of_word(tokens_.word());
      const auto z = finite_of_word(tokens_.word());
      if (!x || !y || !z) {
        return invalid("a vertex has three coordinates that are finite numbers.");
      }
      soup_.positions.push_back({*x, *y, *z});
    }
    if (!next_are({"endloop", "endfacet"})) {
      return invalid("`endloop` and `endfacet` are wanted here, after three vertices.");
    }
    return {};
  }

  TextTokens tokens_;
  const DecodeLimits& limits_;
  TriangleSoup soup_;
};

}  // namespace

bool is_stl(std::span<const std::byte> bytes) {
  if (is_binary_stl(bytes)) return true;
  TextTokens tokens(text_of_file(bytes));
  if (!is_word(tokens.word(), "solid") || !tokens.next_line()) return false;
  const auto word = tokens.word();
  return is_word(word, "facet") || is_word(word, "endsolid");
}

Result<DecodedMesh> decode_stl(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  auto soup = is_binary_stl(bytes) ? read_binary(bytes, limits)
                                   : TextReader(text_of_file(bytes), limits).run();
  if (!soup) return fail(std::move(soup.error()));
  if (soup->positions.empty()) {
    return fail(ErrorCode::no_triangles, "The STL file has no facets.");
  }
  soup->faces.resize(soup->positions.size() / 3);
  for (std::uint32_t f = 0; f < soup->faces.size(); ++f) {
    soup->faces[f] = {3 * f, 3 * f + 1, 3 * f + 2};
  }
  return mesh_of_one_part(MeshFormat::stl, std::move(*soup));
}

}  // namespace geodesic::proto
