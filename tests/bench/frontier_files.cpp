#include "tests/bench/frontier_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/encode/encode_mesh.h"
#include "proto/gltf/annotate.h"
#include "proto/gltf/weights.h"
#include "server/reply/annotated_file.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

// As a file has it: a file's vertices are those of the mesh, in its order.
std::vector<std::byte> file_of(const Mesh& mesh) {
  TriangleSoup soup;
  const auto positions = mesh.positions();
  soup.positions.assign(positions.begin(), positions.end());
  soup.faces = {mesh.faces().begin(), mesh.faces().end()};
  return proto::encode_glb(soup, "mesh");
}

std::string floats_of(const Field& field) {
  std::string bytes;
  for (const double d : field.distance.values()) {
    const auto four = std::bit_cast<std::array<char, 4>>(static_cast<float>(d));
    bytes.append(four.data(), four.size());
  }
  return bytes;
}

}  // namespace

Figures annotated_files(Asked& asked) {
  const std::vector<proto::VertexAttribute> attributes{{"_GEODESIC_DISTANCE", 1}};
  const std::vector<std::byte> file = file_of(asked.adjacency().mesh());
  // So far away to begin with that each number is a weight, as which they are read again.
  const Source from{asked.source().point, asked.farthest()};
  Field field;
  std::string annotated;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    FieldLimits limits;
    limits.keep_details = false;
    field = take(solve_field(Method::back_traced, {}, asked.adjacency(), {&from, 1}, limits,
                             asked.scratch(), Cancel()));
    const auto annotation = take(proto::annotate_gltf(file, {}, {}, attributes));
    const Cancel cancel;
    Poll poll(cancel);
    annotated =
        take(server::write_annotated({reinterpret_cast<const char*>(file.data()), file.size()},
                                     annotation, attributes, {floats_of(field)}, poll));
  });
  const std::span<const std::byte> bytes = std::as_bytes(std::span(annotated));
  const auto read =
      proto::read_face_numbers(bytes, {}, {}, attributes.front().name, proto::FaceNumber::weight);
  figures.is_there = read.has_value();  // not where a part of the mesh cannot be reached
  if (!read) return figures;
  const auto faces = asked.adjacency().mesh().faces();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto [a, b, c] = faces[f];
    const double mean = (field.distance[a] + field.distance[b] + field.distance[c]) / 3;
    figures.off = std::max(figures.off, std::abs(read->by_face[f] / mean - 1));
  }
  return figures;
}

}  // namespace geodesic::bench
