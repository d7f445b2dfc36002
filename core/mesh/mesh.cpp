#include "core/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/mesh/hilbert_order.h"

namespace geodesic {
namespace {

// Faces are addressed as 4 * face + corner in 32 bits, and kNone is taken.
constexpr std::size_t kMaxFaces = (std::size_t{1} << 30) - 1;
constexpr std::size_t kMaxVertices = std::size_t{kNone} - 2;

double flushed(double coordinate) {
  // Adding zero turns -0 into +0, so that equal positions have equal bits.
  return std::abs(coordinate) < Mesh::kMinCoordinate ? 0.0 : coordinate + 0.0;
}

Result<Box> checked_box(const TriangleSoup& soup, Poll& poll) {
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (std::size_t i = 0; i < soup.positions.size() && !poll.cancelled(); ++i) {
    const Vec3 p = soup.positions[i];
    // Written so that NaN fails it.
    const bool usable = std::abs(p.x) <= Mesh::kMaxCoordinate &&
                        std::abs(p.y) <= Mesh::kMaxCoordinate &&
                        std::abs(p.z) <= Mesh::kMaxCoordinate;
    if (!usable) {
      return fail(ErrorCode::mesh_invalid,
                  "the position of vertex " + std::to_string(i) + " is not finite or too large");
    }
    // Of the positions that the mesh gets: a box of 1e-310 would have no finite scale.
    const Vec3 q{flushed(p.x), flushed(p.y), flushed(p.z)};
    box.min = {std::min(box.min.x, q.x), std::min(box.min.y, q.y), std::min(box.min.z, q.z)};
    box.max = {std::max(box.max.x, q.x), std::max(box.max.y, q.y), std::max(box.max.z, q.z)};
  }
  return box;
}

Result<void> check_indices(const TriangleSoup& soup, Poll& poll) {
  for (std::size_t f = 0; f < soup.faces.size() && !poll.cancelled(); ++f) {
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

// A place on the Hilbert curve, in the upper half, and a source vertex.
using Keyed = std::uint64_t;
constexpr unsigned kKeyShift = 32;

// Sorts by places on the curve; those at the same one stay in their order. A radix sort (Knuth, The
// Art of Computer Programming 3, section 5.2.5), from the last digit to the first.
void sort_by_place(std::vector<Keyed>& keyed, Poll& poll) {
  constexpr unsigned kDigitBits = 10;
  static_assert(kHilbertBits % kDigitBits == 0);
  std::vector<Keyed> sorted;
  polled_assign(sorted, keyed.size(), Keyed{0}, poll);
  for (unsigned shift = kKeyShift; shift < kKeyShift + kHilbertBits; shift += kDigitBits) {
    if (poll.ask()) return;
    const auto digit_of = [shift](Keyed key) {
      return key >> shift & ((std::uint64_t{1} << kDigitBits) - 1);
    };
    std::array<std::size_t, (std::size_t{1} << kDigitBits) + 1> begin{};
    for (const Keyed key : keyed) {
      if (poll.cancelled()) return;
      ++begin[digit_of(key) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (const Keyed key : keyed) {
      if (poll.cancelled()) return;
      sorted[begin[digit_of(key)]++] = key;
    }
    keyed.swap(sorted);
  }
}

// Source vertices along the Hilbert curve, those at the same position side by
// side. Ties of the curve are broken by position and number, never by hashing,
// so that no choice of coordinates makes this slower than a sort.
std::vector<std::uint32_t> curve_order(const std::vector<Vec3>& positions, const Box& box,
                                       Poll& poll) {
  const Vec3 size = box.max - box.min;
  const double longest = std::max({size.x, size.y, size.z});
  const double scale = longest > 0 ? 1023.0 / longest : 0.0;
  const auto cell = [scale](double offset) { return static_cast<std::uint32_t>(offset * scale); };

  std::vector<Keyed> keyed;
  polled_assign(keyed, positions.size(), Keyed{0}, poll);
  if (poll.stopped()) return {};
  run_in_blocks(
      keyed.size(), poll, [&](std::size_t, std::size_t begin, std::size_t end, Poll& asked) {
        for (std::size_t i = begin; i < end && !asked.cancelled(); ++i) {
          const Vec3 offset = positions[i] - box.min;
          const std::uint64_t key = hilbert_index(cell(offset.x), cell(offset.y), cell(offset.z));
          keyed[i] = (key << kKeyShift) | i;
        }
      });
  if (poll.stopped()) return {};
  sort_by_place(keyed, poll);
  if (poll.stopped()) return {};

  std::vector<std::uint32_t> order;
  polled_assign(order, keyed.size(), std::uint32_t{0}, poll);
  if (poll.stopped()) return {};
  for (std::size_t i = 0; i < keyed.size(); ++i) order[i] = static_cast<std::uint32_t>(keyed[i]);
  const auto by_position = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 p = positions[a];
    const Vec3 q = positions[b];
    return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
  };
  std::vector<std::uint32_t> spare;
  for (std::size_t begin = 0; begin < keyed.size() && !poll.cancelled();) {
    std::size_t end = begin + 1;
    while (end < keyed.size() && keyed[end] >> kKeyShift == keyed[begin] >> kKeyShift) ++end;
    if (end - begin > 1) polled_sort(order, begin, end, by_position, spare, poll);
    begin = end;
  }
  return order;
}

// For each source vertex the first of those that are to become one with it because
// a face has both as corners at the same position.
std::vector<std::uint32_t> joined_in_faces(const TriangleSoup& soup,
                                           const std::vector<Vec3>& positions, Poll& poll) {
  std::vector<std::uint32_t> first(positions.size());
  std::iota(first.begin(), first.end(), 0U);
  const auto find = [&](std::uint32_t v) {
    while (first[v] != v) v = first[v] = first[first[v]];
    return v;
  };
  for (const auto& face : soup.faces) {
    if (poll.cancelled()) break;
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

// A mesh that is being built. Each step leaves off when the poll says to stop.
struct MeshBuilder {
  void weld(const TriangleSoup& soup, Weld weld, Poll& poll);
  void order_faces(const TriangleSoup& soup, Poll& poll);
  void measure(Poll& poll);

  std::vector<Vec3> positions;
  std::vector<Triangle> faces;
  std::vector<std::uint32_t> vertex_of_source;
  std::vector<std::uint32_t> source_of_vertex;
  std::vector<std::uint32_t> face_of_source;
  std::vector<std::uint32_t> source_of_face;
  std::vector<Mesh::DroppedFace> dropped;
  std::uint32_t zero_area_faces = 0;
  Box box;
  double area = 0;
};

// Numbers the vertices along the curve, those at the same position as one.
void MeshBuilder::weld(const TriangleSoup& soup, Weld weld, Poll& poll) {
  const std::size_t count = soup.positions.size();
  std::vector<Vec3> flushed_positions;
  polled_assign(flushed_positions, count, Vec3{}, poll);
  if (poll.stopped()) return;
  run_in_blocks(count, poll, [&](std::size_t, std::size_t begin, std::size_t end, Poll& asked) {
    for (std::size_t i = begin; i < end && !asked.cancelled(); ++i) {
      const Vec3 p = soup.positions[i];
      flushed_positions[i] = {flushed(p.x), flushed(p.y), flushed(p.z)};
    }
  });
  if (poll.stopped()) return;
  const std::vector<std::uint32_t> order = curve_order(flushed_positions, box, poll);
  polled_assign(vertex_of_source, count, kNone, poll);
  if (poll.stopped()) return;
  positions.reserve(count);
  source_of_vertex.reserve(count);
  // Those to become one follow one another, or else the first of them, which has the
  // least number and so comes first on the curve, is known.
  const std::vector<std::uint32_t> first = weld == Weld::off
                                               ? joined_in_faces(soup, flushed_positions, poll)
                                               : std::vector<std::uint32_t>();
  for (const std::uint32_t source : order) {
    if (poll.cancelled()) return;
    const Vec3 p = flushed_positions[source];
    const bool is_new =
        weld == Weld::off ? first[source] == source : positions.empty() || !(positions.back() == p);
    if (is_new) {
      positions.push_back(p);
      source_of_vertex.push_back(source);
    }
    vertex_of_source[source] = is_new || weld != Weld::off
                                   ? static_cast<std::uint32_t>(positions.size() - 1)
                                   : vertex_of_source[first[source]];
  }
  positions.shrink_to_fit();
  source_of_vertex.shrink_to_fit();
}

// Faces in the order of their first vertex on the curve (a counting sort).
void MeshBuilder::order_faces(const TriangleSoup& soup, Poll& poll) {
  const auto has_surface = [](const Triangle& t) {
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
  };
  std::vector<Triangle> welded;  // by source face
  polled_assign(welded, soup.faces.size(), Triangle{}, poll);
  if (poll.stopped()) return;
  run_in_blocks(
      welded.size(), poll, [&](std::size_t, std::size_t begin, std::size_t end, Poll& asked) {
        for (std::size_t f = begin; f < end && !asked.cancelled(); ++f) {
          const Triangle& t = soup.faces[f];
          welded[f] = {vertex_of_source[t[0]], vertex_of_source[t[1]], vertex_of_source[t[2]]};
        }
      });
  std::vector<std::uint32_t> next;  // place of the next face whose first vertex this is
  polled_assign(next, positions.size() + 1, std::uint32_t{0}, poll);
  polled_assign(face_of_source, welded.size(), kNone, poll);
  if (poll.stopped()) return;
  for (std::size_t f = 0; f < welded.size(); ++f) {
    if (poll.cancelled()) return;
    const Triangle& t = welded[f];
    if (has_surface(t)) {
      ++next[std::min({t[0], t[1], t[2]}) + 1];
    } else {
      dropped.push_back({static_cast<std::uint32_t>(f), t});
    }
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  polled_assign(source_of_face, welded.size() - dropped.size(), kNone, poll);
  if (poll.stopped()) return;
  for (std::size_t f = 0; f < welded.size(); ++f) {
    if (poll.cancelled()) return;
    const Triangle& t = welded[f];
    if (!has_surface(t)) continue;
    const std::uint32_t face = next[std::min({t[0], t[1], t[2]})]++;
    source_of_face[face] = static_cast<std::uint32_t>(f);
    face_of_source[f] = face;
  }
  polled_assign(faces, source_of_face.size(), Triangle{}, poll);
  if (poll.stopped()) return;
  run_in_blocks(faces.size(), poll,
                [&](std::size_t, std::size_t begin, std::size_t end, Poll& asked) {
                  for (std::size_t f = begin; f < end && !asked.cancelled(); ++f) {
                    faces[f] = welded[source_of_face[f]];
                  }
                });
}

void MeshBuilder::measure(Poll& poll) {
  struct Measure {
    double area = 0;
    std::uint32_t without_area = 0;
  };
  std::vector<Measure> measures(count_blocks(faces.size()));
  run_in_blocks(faces.size(), poll,
                [&](std::size_t block, std::size_t begin, std::size_t end, Poll& asked) {
                  Measure measure;
                  for (std::size_t f = begin; f < end && !asked.cancelled(); ++f) {
                    const Vec3 a = positions[faces[f][0]];
                    const Vec3 b = positions[faces[f][1]];
                    const Vec3 c = positions[faces[f][2]];
                    measure.area += 0.5 * norm(cross(b - a, c - a));
                    if (Mesh::is_without_area(a, b, c)) ++measure.without_area;
                  }
                  measures[block] = measure;
                });
  for (const Measure& measure : measures) {
    area += measure.area;
    zero_area_faces += measure.without_area;
  }
}

}  // namespace

Result<Mesh> Mesh::build(const TriangleSoup& soup, Weld weld) {
  return build(soup, weld, Cancel());
}

Result<Mesh> Mesh::build(const TriangleSoup& soup, Weld weld, const Cancel& cancel) {
  if (soup.faces.empty()) return fail(ErrorCode::no_triangles, "the mesh has no triangles");
  if (soup.positions.size() > kMaxVertices) {
    return fail_limit(ErrorCode::too_many_vertices, "too many vertices", kMaxVertices,
                      soup.positions.size());
  }
  if (soup.faces.size() > kMaxFaces) {
    return fail_limit(ErrorCode::too_many_faces, "too many faces", kMaxFaces, soup.faces.size());
  }
  Poll poll(cancel);
  if (auto indices = check_indices(soup, poll); !indices) return fail(indices.error());
  MeshBuilder mesh;
  if (auto box = checked_box(soup, poll); box) {
    mesh.box = *box;
  } else {
    return fail(box.error());
  }
  // About what part of the time each step takes.
  cancel.report(0.05);
  if (!poll.ask()) mesh.weld(soup, weld, poll);
  cancel.report(0.6);
  if (!poll.ask()) mesh.order_faces(soup, poll);
  cancel.report(0.9);
  if (!poll.ask()) mesh.measure(poll);
  if (poll.ask()) return fail_stopped(cancel);
  if (mesh.faces.empty()) {
    return fail(ErrorCode::mesh_invalid, "every face has two corners at the same position");
  }
  return Mesh(Parts{.positions = SharedArray(std::move(mesh.positions)),
                    .faces = SharedArray(std::move(mesh.faces)),
                    .vertex_of_source = SharedArray(std::move(mesh.vertex_of_source)),
                    .source_of_vertex = SharedArray(std::move(mesh.source_of_vertex)),
                    .face_of_source = SharedArray(std::move(mesh.face_of_source)),
                    .source_of_face = SharedArray(std::move(mesh.source_of_face)),
                    .dropped = SharedArray(std::move(mesh.dropped)),
                    .zero_area_faces = mesh.zero_area_faces,
                    .box = mesh.box,
                    .area = mesh.area});
}

bool Mesh::is_without_area(Vec3 a, Vec3 b, Vec3 c) {
  const double longest2 = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
  return norm(cross(b - a, c - a)) <= tolerance::kZeroArea * longest2;
}

namespace {

auto find_dropped(std::span<const Mesh::DroppedFace> dropped, std::uint32_t source_face) {
  return std::lower_bound(
      dropped.begin(), dropped.end(), source_face,
      [](const Mesh::DroppedFace& face, std::uint32_t f) { return face.source_face < f; });
}

}  // namespace

Triangle Mesh::dropped_face(std::uint32_t source_face) const {
  return find_dropped(parts_.dropped, source_face)->vertices;
}

bool Mesh::is_dropped(std::uint32_t source_face) const {
  const auto it = find_dropped(parts_.dropped, source_face);
  return it != dropped_faces().end() && it->source_face == source_face;
}

std::size_t Mesh::bytes() const {
  return sizeof(Mesh) + parts_.positions.bytes() + parts_.faces.bytes() +
         parts_.vertex_of_source.bytes() + parts_.source_of_vertex.bytes() +
         parts_.face_of_source.bytes() + parts_.source_of_face.bytes() + parts_.dropped.bytes();
}

}  // namespace geodesic
