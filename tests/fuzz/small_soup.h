// A small mesh from any bytes: few vertices on a lattice, so that equal positions, thin
// and flat faces, edges of many faces and loose parts come about by themselves.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/mesh/mesh.h"
#include "core/mesh/triangle_soup.h"
#include "core/surface/point.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {

// The bytes one after the other, and zeros after the last.
class Reader {
 public:
  explicit Reader(Input input) : input_(input) {}
  std::uint8_t byte() { return at_ < input_.size() ? input_[at_++] : std::uint8_t{0}; }
  [[nodiscard]] bool is_empty() const { return at_ >= input_.size(); }

 private:
  Input input_;
  std::size_t at_ = 0;
};

// Two bytes of head, two a vertex, three a face.
inline TriangleSoup small_soup(Reader& reader) {
  TriangleSoup soup;
  const std::uint8_t head = reader.byte();
  const std::size_t vertices = 3 + head % 22;
  const double stretch = std::pow(10.0, reader.byte() % 4);
  for (std::size_t i = 0; i < vertices; ++i) {
    const std::uint8_t xy = reader.byte();
    const std::uint8_t z = reader.byte();
    const double aside = 0.01 * (z >> 4U);
    soup.positions.push_back(
        {stretch * (xy & 7U) + aside, (xy >> 3U & 7U) - aside, static_cast<double>(z & 3U)});
  }
  const auto corner = [&] { return static_cast<std::uint32_t>(reader.byte() % vertices); };
  do {
    soup.faces.push_back({corner(), corner(), corner()});
  } while (!reader.is_empty() && soup.faces.size() < 48);
  return soup;
}

// The mesh of such a soup; null where there is none.
inline std::shared_ptr<const Mesh> small_mesh(Reader& reader) {
  auto built = Mesh::build(small_soup(reader));
  return built ? std::make_shared<const Mesh>(std::move(*built)) : nullptr;
}

// Three bytes: a corner of a face, a place on one of its sides, or one inside.
inline SurfacePoint small_point(const Adjacency& adjacency, Reader& reader) {
  const std::uint32_t face = reader.byte() % static_cast<std::uint32_t>(adjacency.faces().size());
  const std::uint8_t kind = reader.byte();
  const double part = (1 + reader.byte() % 15) / 16.0;
  const std::uint32_t c = kind % 3U;
  std::array<double, 3> bary{};
  bary[c] = 1;
  if (kind >= 128) bary[next_corner(c)] = part;
  if (kind >= 192) bary[previous_corner(c)] = 1 - part;
  return point_on_face(adjacency, face, bary);
}

}  // namespace geodesic::fuzz
