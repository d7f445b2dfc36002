#include "core/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>

#include "core/hilbert_order.h"

namespace geodesic {
namespace {

// Faces are addressed as 4 * face + corner in 32 bits, and kNone is taken.
constexpr std::size_t kMaxFaces = (std::size_t{1} << 30) - 1;
constexpr std::size_t kMaxVertices = std::size_t{kNone} - 2;

// A face counts as without area when its height is below this part of its longest edge.
constexpr double kZeroAreaRatio = 1e-12;

double flushed(double coordinate) {
  // Adding zero turns -0 into +0, so that equal positions have equal bits.
  return std::abs(coordinate) < Mesh::kMinCoordinate ? 0.0 : coordinate + 0.0;
}

Result<Box> checked_box(const TriangleSoup& soup) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    const Vec3 p = soup.positions[i];
    // Written so that NaN fails it.
    const bool usable = std::abs(p.x) <= Mesh::kMaxCoordinate &&
                        std::abs(p.y) <= Mesh::kMaxCoordinate &&
                        std::abs(p.z) <= Mesh::kMaxCoordinate;
    if (!usable) {
      return fail(ErrorCode::mesh_invalid,
                  "the position of vertex " + std::to_string(i) + " is not finite or too large");
    }
    box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
    box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
  }
  return box;
}

Result<void> check_indices(const TriangleSoup& soup) {
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    for (const std::uint32_t v : soup.faces[f]) {
      if (v >= soup.positions.size()) {
        return fail(ErrorCode::index_out_of_range, "face " + std::to_string(f) + " names vertex " +
                                                       std::to_string(v) + " of " +
                                                       std::to_string(soup.positions.size()));
      }
    }
  }
  return {};
}

// Source vertices along the Hilbert curve, those at the same position side by
// side. Ties of the curve are broken by position and number, never by hashing,
// so that no choice of coordinates makes this slower than a sort.
std::vector<std::uint32_t> curve_order(const std::vector<Vec3>& positions, const Box& box) {
  const Vec3 size = box.max - box.min;
  const double longest = std::max({size.x, size.y, size.z});
  const double scale = longest > 0 ? 1023.0 / longest : 0.0;
  const auto cell = [scale](double offset) { return static_cast<std::uint32_t>(offset * scale); };

  std::vector<std::uint64_t> keyed(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3 offset = positions[i] - box.min;
    const std::uint64_t key = hilbert_index(cell(offset.x), cell(offset.y), cell(offset.z));
    keyed[i] = (key << 32U) | i;
  }
  std::sort(keyed.begin(), keyed.end());

  std::vector<std::uint32_t> order(positions.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) order[i] = static_cast<std::uint32_t>(keyed[i]);
  const auto by_position = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 p = positions[a];
    const Vec3 q = positions[b];
    return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
  };
  for (std::size_t begin = 0; begin < keyed.size();) {
    std::size_t end = begin + 1;
    while (end < keyed.size() && (keyed[end] >> 32U) == (keyed[begin] >> 32U)) ++end;
    if (end - begin > 1) {
      std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin),
                order.begin() + static_cast<std::ptrdiff_t>(end), by_position);
    }
    begin = end;
  }
  return order;
}

// For each source vertex the first of those that are to become one with it because
// a face has both as corners at the same position.
std::vector<std::uint32_t> joined_in_faces(const TriangleSoup& soup,
                                           const std::vector<Vec3>& positions) {
  std::vector<std::uint32_t> first(positions.size());
  std::iota(first.begin(), first.end(), 0U);
  const auto find = [&](std::uint32_t v) {
    while (first[v] != v) v = first[v] = first[first[v]];
    return v;
  };
  for (const auto& face : soup.faces) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = face[c];
      const std::uint32_t b = face[(c + 1) % 3];
      if (a == b || !(positions[a] == positions[b])) continue;
      const std::uint32_t one = find(a);
      const std::uint32_t other = find(b);
      first[std::max(one, other)] = std::min(one, other);
    }
  }
  for (std::uint32_t v = 0; v < first.size(); ++v) first[v] = find(v);
  return first;
}

}  // namespace

Result<Mesh> Mesh::build(const TriangleSoup& soup, Weld weld) {
  if (soup.faces.empty()) return fail(ErrorCode::no_triangles, "the mesh has no triangles");
  if (soup.positions.size() > kMaxVertices) {
    return fail_limit(ErrorCode::too_many_vertices, "too many vertices", kMaxVertices,
                      soup.positions.size());
  }
  if (soup.faces.size() > kMaxFaces) {
    return fail_limit(ErrorCode::too_many_faces, "too many faces", kMaxFaces, soup.faces.size());
  }
  if (auto indices = check_indices(soup); !indices) return fail(indices.error());
  Mesh mesh;
  if (auto box = checked_box(soup); box) {
    mesh.box_ = *box;
  } else {
    return fail(box.error());
  }

  // Weld, and number the vertices along the curve.
  std::vector<Vec3> flushed_positions(soup.positions.size());
  std::transform(soup.positions.begin(), soup.positions.end(), flushed_positions.begin(),
                 [](Vec3 p) {
                   return Vec3{flushed(p.x), flushed(p.y), flushed(p.z)};
                 });
  const std::vector<std::uint32_t> order = curve_order(flushed_positions, mesh.box_);
  mesh.vertex_of_source_.resize(soup.positions.size());
  mesh.positions_.reserve(soup.positions.size());
  mesh.source_of_vertex_.reserve(soup.positions.size());
  if (weld == Weld::by_position) {
    for (const std::uint32_t source : order) {
      const Vec3 p = flushed_positions[source];
      if (mesh.positions_.empty() || !(mesh.positions_.back() == p)) {
        mesh.positions_.push_back(p);
        mesh.source_of_vertex_.push_back(source);
      }
      mesh.vertex_of_source_[source] = static_cast<std::uint32_t>(mesh.positions_.size() - 1);
    }
  } else {
    const std::vector<std::uint32_t> first = joined_in_faces(soup, flushed_positions);
    // The first of those joined has the least number, so the curve comes to it first.
    for (const std::uint32_t source : order) {
      if (first[source] == source) {
        mesh.vertex_of_source_[source] = static_cast<std::uint32_t>(mesh.positions_.size());
        mesh.positions_.push_back(flushed_positions[source]);
        mesh.source_of_vertex_.push_back(source);
      } else {
        mesh.vertex_of_source_[source] = mesh.vertex_of_source_[first[source]];
      }
    }
  }
  mesh.positions_.shrink_to_fit();
  mesh.source_of_vertex_.shrink_to_fit();

  // Faces in the order of their first vertex on the curve (a counting sort).
  const auto welded = [&](std::size_t source_face) {
    const Triangle& t = soup.faces[source_face];
    return Triangle{mesh.vertex_of_source_[t[0]], mesh.vertex_of_source_[t[1]],
                    mesh.vertex_of_source_[t[2]]};
  };
  const auto has_surface = [](const Triangle& t) {
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
  };
  std::vector<std::uint32_t> begin(mesh.positions_.size() + 1, 0);
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    const Triangle t = welded(f);
    if (has_surface(t)) {
      ++begin[std::min({t[0], t[1], t[2]}) + 1];
    } else {
      mesh.dropped_.push_back({static_cast<std::uint32_t>(f), t});
    }
  }
  if (mesh.dropped_.size() == soup.faces.size()) {
    return fail(ErrorCode::mesh_invalid, "every face has two corners at the same position");
  }
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  mesh.faces_.resize(soup.faces.size() - mesh.dropped_.size());
  mesh.source_of_face_.resize(mesh.faces_.size());
  mesh.face_of_source_.assign(soup.faces.size(), kNone);
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    const Triangle t = welded(f);
    if (!has_surface(t)) continue;
    const std::uint32_t face = begin[std::min({t[0], t[1], t[2]})]++;
    mesh.faces_[face] = t;
    mesh.source_of_face_[face] = static_cast<std::uint32_t>(f);
    mesh.face_of_source_[f] = face;
  }

  for (const Triangle& t : mesh.faces_) {
    const Vec3 a = mesh.positions_[t[0]];
    const Vec3 b = mesh.positions_[t[1]];
    const Vec3 c = mesh.positions_[t[2]];
    mesh.area_ += 0.5 * norm(cross(b - a, c - a));
    if (is_without_area(a, b, c)) ++mesh.zero_area_faces_;
  }
  return mesh;
}

bool Mesh::is_without_area(Vec3 a, Vec3 b, Vec3 c) {
  const double longest2 = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
  return norm(cross(b - a, c - a)) <= kZeroAreaRatio * longest2;
}

Triangle Mesh::dropped_face(std::uint32_t source_face) const {
  const auto it = std::lower_bound(
      dropped_.begin(), dropped_.end(), source_face,
      [](const DroppedFace& dropped, std::uint32_t f) { return dropped.source_face < f; });
  return it->vertices;
}

std::size_t Mesh::bytes() const {
  return sizeof(Mesh) + positions_.capacity() * sizeof(Vec3) +
         faces_.capacity() * sizeof(Triangle) + dropped_.capacity() * sizeof(DroppedFace) +
         sizeof(std::uint32_t) * (vertex_of_source_.capacity() + source_of_vertex_.capacity() +
                                  face_of_source_.capacity() + source_of_face_.capacity());
}

}  // namespace geodesic
