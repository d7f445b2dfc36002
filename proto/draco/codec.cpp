// The one place that includes Draco. Only its decoder and encoder of memory are
// used, never its file readers; what it decodes is checked again, since its
// indices and its mapping of points to values come from the bitstream.
#include "proto/draco/codec.h"

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "proto/encode/encode_mesh.h"

namespace geodesic::proto {
namespace {

constexpr int kMaxPositionBits = 30;  // what Draco's quantiser can do

// The value that integers of a type stand for when they are normalised, or 0.
double full_scale(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return std::numeric_limits<std::int8_t>::max();
    case draco::DT_UINT8:
      return std::numeric_limits<std::uint8_t>::max();
    case draco::DT_INT16:
      return std::numeric_limits<std::int16_t>::max();
    case draco::DT_UINT16:
      return std::numeric_limits<std::uint16_t>::max();
    default:
      return 0;
  }
}

// Calls `take(point, numbers)` for each point of the mesh. `what` is what a message calls them.
template <class Number, int kComponents, class Take>
Result<void> read_numbers(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                          bool normalized, const std::string& what, const Take& take) {
  if (attribute.num_components() != kComponents) {
    return fail(ErrorCode::mesh_invalid, "The Draco " + what + " do not have " +
                                             (kComponents == 1 ? "one" : "three") +
                                             (kComponents == 1 ? " component." : " components."));
  }
  const std::size_t values = attribute.size();
  const auto stride = static_cast<std::size_t>(attribute.byte_stride());
  const std::size_t value_size =
      kComponents * static_cast<std::size_t>(draco::DataTypeLength(attribute.data_type()));
  if (attribute.buffer() == nullptr || stride < value_size || attribute.byte_offset() < 0 ||
      attribute.buffer()->data_size() <
          static_cast<std::size_t>(attribute.byte_offset()) + values * stride) {
    return fail(ErrorCode::mesh_invalid, "The Draco " + what + " are not complete.");
  }
  // Draco would read any byte as a bool, which is undefined; and no number is one.
  if (attribute.data_type() == draco::DT_BOOL) {
    return fail(ErrorCode::mesh_invalid, "The Draco " + what + " are of a type that is not known.");
  }
  const bool is_float = attribute.data_type() == draco::DT_FLOAT32;
  // Whether integers are fractions is for the accessor to say, whatever the bitstream says.
  draco::GeometryAttribute raw = attribute;
  raw.set_normalized(false);
  const double scale = normalized ? full_scale(attribute.data_type()) : 0;
  if (!attribute.is_mapping_identity() && attribute.indices_map_size() < mesh.num_points()) {
    return fail(ErrorCode::mesh_invalid, "The Draco " + what + " are not complete.");
  }
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    if (value.value() >= values) {
      return fail(ErrorCode::mesh_invalid,
                  "The Draco " + what + " leave out point " + std::to_string(i) + ".");
    }
    std::array<Number, kComponents> read;
    if (is_float) {
      std::array<float, kComponents> floats;
      std::memcpy(floats.data(), attribute.GetAddress(value), sizeof floats);
      std::copy(floats.begin(), floats.end(), read.begin());
    } else if (!raw.ConvertValue<Number, kComponents>(value, read.data())) {
      return fail(ErrorCode::mesh_invalid,
                  "The Draco " + what + " are of a type that is not known.");
    }
    std::array<double, kComponents> numbers;
    for (int c = 0; c < kComponents; ++c) {
      numbers[c] = scale == 0 ? read[c] : std::max(read[c] / scale, -1.0);
    }
    take(i, numbers);
  }
  return {};
}

Result<std::vector<Vec3>> positions_of(const draco::Mesh& mesh,
                                       const draco::PointAttribute& attribute, bool normalized) {
  std::vector<Vec3> positions(mesh.num_points());
  const auto read = read_numbers<float, 3>(mesh, attribute, normalized, "positions",
                                           [&](std::uint32_t i, const std::array<double, 3>& xyz) {
                                             positions[i] = {xyz[0], xyz[1], xyz[2]};
                                           });
  if (!read) return fail(read.error());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3& p = positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      return fail(ErrorCode::mesh_invalid,
                  "The position of Draco point " + std::to_string(i) + " is not finite.");
    }
  }
  return positions;
}

Result<TriangleSoup> soup_of(const draco::Mesh& mesh, std::optional<DracoAttribute> position) {
  const draco::PointAttribute* attribute =
      position ? mesh.GetAttributeByUniqueId(position->unique_id)
               : mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (attribute == nullptr) {
    return fail(ErrorCode::mesh_invalid,
                position ? "The Draco data has no attribute of the id that POSITION refers to."
                         : "The Draco data has no positions.");
  }
  auto positions = positions_of(mesh, *attribute, position && position->normalized);
  if (!positions) return fail(std::move(positions.error()));
  TriangleSoup soup;
  soup.positions = std::move(*positions);
  soup.faces.resize(mesh.num_faces());
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = face[static_cast<int>(corner)].value();
      if (vertex >= mesh.num_points()) {
        return fail(ErrorCode::index_out_of_range,
                    "Draco face " + std::to_string(f) + " refers to point " +
                        std::to_string(vertex) + " of " + std::to_string(mesh.num_points()) + ".");
      }
      soup.faces[f][corner] = vertex;
    }
  }
  return soup;
}

Result<std::vector<double>> numbers_of(const draco::Mesh& mesh, DracoAttribute which) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(which.unique_id);
  if (attribute == nullptr) {
    return fail(ErrorCode::mesh_invalid, "The Draco data has no attribute of the id " +
                                             std::to_string(which.unique_id) + ".");
  }
  std::vector<double> numbers(mesh.num_points());
  const auto read = read_numbers<double, 1>(
      mesh, *attribute, which.normalized, "numbers",
      [&](std::uint32_t i, const std::array<double, 1>& number) { numbers[i] = number[0]; });
  if (!read) return fail(read.error());
  return numbers;
}

// What `use` makes of the mesh of a bitstream.
template <class Use>
auto decode_and(std::span<const std::byte> bytes, const DracoLimits& limits, const Use& use)
    -> decltype(use(std::declval<const draco::Mesh&>())) {
  if (const auto claims = check_draco_claims(bytes, limits); !claims) return fail(claims.error());
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok() || decoded.value() == nullptr) {
      return fail(ErrorCode::mesh_invalid, "The Draco data is damaged.");
    }
    const draco::Mesh& mesh = *decoded.value();
    if (mesh.num_points() > limits.max_vertices) {
      return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.",
                        limits.max_vertices, mesh.num_points());
    }
    return use(mesh);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::too_large, "The Draco data needs more memory than there is.");
  } catch (const std::exception&) {  // such as length_error, from counts deep inside
    return fail(ErrorCode::mesh_invalid, "The Draco data is damaged.");
  }
}

}  // namespace

Result<TriangleSoup> decode_draco(std::span<const std::byte> bytes, const DracoLimits& limits,
                                  std::optional<DracoAttribute> position) {
  return decode_and(bytes, limits,
                    [&](const draco::Mesh& mesh) { return soup_of(mesh, position); });
}

Result<std::vector<double>> decode_draco_numbers(std::span<const std::byte> bytes,
                                                 const DracoLimits& limits,
                                                 DracoAttribute attribute) {
  return decode_and(bytes, limits,
                    [&](const draco::Mesh& mesh) { return numbers_of(mesh, attribute); });
}

Result<std::vector<std::byte>> encode_drc(const TriangleSoup& soup, int position_bits) {
  if (position_bits < 0 || position_bits > kMaxPositionBits) {
    return fail(ErrorCode::value_out_of_range,
                "Positions can be quantised to 1 to 30 bits, or to 0 for not at all.",
                "position_bits");
  }
  if (soup.faces.empty()) {
    return fail(ErrorCode::no_triangles, "Draco stores triangles, and the mesh has none.");
  }
  if (soup.positions.size() > std::numeric_limits<std::int32_t>::max()) {
    return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.",
                      std::numeric_limits<std::int32_t>::max(), soup.positions.size());
  }
  const auto points = static_cast<std::uint32_t>(soup.positions.size());
  try {
    draco::Mesh mesh;
    mesh.set_num_points(points);
    draco::GeometryAttribute layout;
    layout.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
    draco::PointAttribute* attribute = mesh.attribute(mesh.AddAttribute(layout, true, points));
    for (std::uint32_t i = 0; i < points; ++i) {
      const Vec3& p = soup.positions[i];
      const float xyz[3] = {static_cast<float>(p.x), static_cast<float>(p.y),
                            static_cast<float>(p.z)};
      attribute->SetAttributeValue(draco::AttributeValueIndex(i), xyz);
    }
    mesh.SetNumFaces(soup.faces.size());
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
      draco::Mesh::Face face;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = soup.faces[f][corner];
        if (vertex >= points) {
          return fail(ErrorCode::index_out_of_range,
                      "Face " + std::to_string(f) + " refers to vertex " + std::to_string(vertex) +
                          " of " + std::to_string(points) + ".");
        }
        face[static_cast<int>(corner)] = draco::PointIndex(vertex);
      }
      mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(f)), face);
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    if (position_bits > 0) {
      encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
    }
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) {
      return fail(ErrorCode::unsupported, "Draco can't encode this mesh.");
    }
    const auto* data = reinterpret_cast<const std::byte*>(buffer.data());
    return std::vector<std::byte>(data, data + buffer.size());
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::too_large, "Encoding the mesh needs more memory than there is.");
  }
}

}  // namespace geodesic::proto
