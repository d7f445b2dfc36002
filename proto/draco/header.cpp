#include "proto/draco/header.h"

#include <algorithm>
#include <string>

namespace geodesic::proto {
namespace {

constexpr char kMagic[] = {'D', 'R', 'A', 'C', 'O'};
constexpr std::uint32_t kMeshType = 1;
constexpr std::uint32_t kSequentialMethod = 0;
constexpr std::uint32_t kEdgebreakerMethod = 1;
constexpr std::uint32_t kMetadataFlag = 0x8000;
constexpr int kMaxMetadataDepth = 16;

// Faces or points that one byte may stand for, and what even the smallest file
// may claim. The reference encoder's densest file of any use is a flat regular
// grid at its slowest level: 106 faces a byte (316 x 316 vertices, 14 bits), and
// scanned meshes have one to four. Only at 1 bit, when all vertices collapse into
// the corners of the box, does a grid of a million reach 684.
constexpr std::uint64_t kClaimsPerByte = 256;
constexpr std::uint64_t kClaimsForFree = 4096;

// Little-endian reading that remembers having come to the end.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool good() const { return good_; }

  std::uint32_t fixed(std::size_t size) {
    std::uint32_t value = 0;
    if (!have(size)) return 0;
    for (std::size_t i = size; i-- > 0;) {
      value = value << 8 | std::to_integer<std::uint32_t>(bytes_[i]);
    }
    bytes_ = bytes_.subspan(size);
    return value;
  }

  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const std::uint32_t byte = fixed(1);
      value |= std::uint64_t{byte & 0x7F} << shift;
      if ((byte & 0x80) == 0) return value;
    }
    good_ = false;
    return 0;
  }

  void skip(std::uint64_t size) {
    if (have(size)) bytes_ = bytes_.subspan(size);
  }

 private:
  bool have(std::uint64_t size) {
    good_ = good_ && size <= bytes_.size();
    return good_;
  }

  std::span<const std::byte> bytes_;
  bool good_ = true;
};

void skip_metadata(Reader& reader, int depth) {
  const std::uint64_t entries = reader.varint();
  for (std::uint64_t i = 0; i < entries && reader.good(); ++i) {
    reader.skip(reader.fixed(1));  // name
    reader.skip(reader.varint());  // value
  }
  const std::uint64_t children = reader.varint();
  for (std::uint64_t i = 0; i < children && reader.good(); ++i) {
    // The library recurses here without a bound.
    if (depth == kMaxMetadataDepth) return reader.skip(~std::uint64_t{0});
    reader.skip(reader.fixed(1));
    skip_metadata(reader, depth + 1);
  }
}

tl::unexpected<Error> invalid(const std::string& detail) {
  return fail(ErrorCode::mesh_invalid, detail);
}

}  // namespace

bool is_draco(std::span<const std::byte> bytes) {
  return bytes.size() >= std::size(kMagic) &&
         std::equal(std::begin(kMagic), std::end(kMagic), bytes.begin(),
                    [](char c, std::byte b) { return std::byte(c) == b; });
}

Result<DracoClaims> check_draco_claims(std::span<const std::byte> bytes,
                                       const DracoLimits& limits) {
  if (!is_draco(bytes)) return invalid("The Draco data does not start with DRACO.");
  Reader reader(bytes.subspan(std::size(kMagic)));
  const std::uint32_t major = reader.fixed(1);
  const std::uint32_t minor = reader.fixed(1);
  const std::uint32_t version = major << 8 | minor;
  const std::uint32_t type = reader.fixed(1);
  const std::uint32_t method = reader.fixed(1);
  const std::uint32_t flags = reader.fixed(2);
  if (!reader.good()) return invalid("The Draco data ends within its header.");
  if (type != kMeshType) {
    return fail(ErrorCode::no_triangles, "The Draco data is a point cloud: it has no triangles.");
  }
  if (version < 0x0100 || version > 0x0202) {
    return invalid("The Draco data is of version " + std::to_string(major) + "." +
                   std::to_string(minor) + ", which is not known.");
  }
  if (method != kSequentialMethod && method != kEdgebreakerMethod) {
    return invalid("The Draco data is encoded by a method that is not known.");
  }
  if (version >= 0x0103 && (flags & kMetadataFlag) != 0) {
    const std::uint64_t attributes = reader.varint();
    for (std::uint64_t i = 0; i < attributes && reader.good(); ++i) {
      (void)reader.varint();  // unique id
      skip_metadata(reader, 0);
    }
    skip_metadata(reader, 0);
  }

  DracoClaims claims;
  std::uint64_t seams = 0;  // attributes with a connectivity of their own
  if (method == kSequentialMethod) {
    const bool fixed = version < 0x0202;
    claims.faces = fixed ? reader.fixed(4) : reader.varint();
    claims.points = fixed ? reader.fixed(4) : reader.varint();
  } else {
    const auto count = [&] { return version < 0x0200 ? reader.fixed(4) : reader.varint(); };
    (void)reader.fixed(1);                // traversal
    if (version < 0x0202) (void)count();  // new vertices
    claims.points = count();
    claims.faces = count();
    seams = reader.fixed(1);
    const std::uint64_t symbols = count();
    const std::uint64_t splits = count();
    if (symbols > claims.faces || splits > symbols || claims.points > 3 * claims.faces) {
      return invalid("The counts in the Draco header contradict each other.");
    }
  }
  if (!reader.good()) return invalid("The Draco data ends within its counts.");
  if (claims.faces == 0) {
    return fail(ErrorCode::no_triangles, "The Draco data has no triangles.");
  }
  if (claims.points > limits.max_vertices) {
    return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.",
                      limits.max_vertices, claims.points);
  }
  if (claims.faces > limits.max_faces) {
    return fail_limit(ErrorCode::too_many_faces, "The mesh has too many faces.", limits.max_faces,
                      claims.faces);
  }
  // Each seam costs a table of corners.
  const std::uint64_t claimed = std::max(claims.points, claims.faces * (1 + seams));
  if (claimed > kClaimsForFree + kClaimsPerByte * bytes.size()) {
    return invalid("The Draco data claims " + std::to_string(claims.faces) + " faces and " +
                   std::to_string(claims.points) + " points in " + std::to_string(bytes.size()) +
                   " bytes.");
  }
  return claims;
}

}  // namespace geodesic::proto
