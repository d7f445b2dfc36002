#include "core/extent/part_by_area.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace geodesic {

bool is_of_file(const Mesh& mesh, std::uint32_t vertex) {
  const std::uint32_t source = mesh.source_of_vertex(vertex);
  return source < mesh.source_vertex_count() && mesh.vertex_of_source()[source] == vertex;
}

namespace {

// The vertices of the part that has most of the file's; of the first of several. Empty if there is
// none, or the poll says to stop.
std::vector<std::uint32_t> vertices_of_largest_part(const Adjacency& adjacency, Poll& poll) {
  const std::uint32_t count = adjacency.mesh().vertex_count();
  std::vector<bool> is_known(count);
  std::vector<std::uint32_t> largest;
  std::size_t most_of_file = 0;
  for (std::uint32_t start = 0; start < count; ++start) {
    if (poll.cancelled()) return {};
    if (is_known[start] || adjacency.corners(start).empty()) continue;
    std::vector<std::uint32_t> part{start};
    is_known[start] = true;
    for (std::size_t i = 0; i < part.size(); ++i) {
      for (const std::uint32_t corner : adjacency.corners(part[i])) {
        if (poll.cancelled()) return {};
        for (const std::uint32_t v : adjacency.face(face_of(corner)).vertex) {
          if (is_known[v]) continue;
          is_known[v] = true;
          part.push_back(v);
        }
      }
    }
    std::size_t of_file = 0;
    for (const std::uint32_t v : part) {
      if (poll.cancelled()) return {};
      if (is_of_file(adjacency.mesh(), v)) ++of_file;
    }
    if (of_file > most_of_file) {
      most_of_file = of_file;
      largest = std::move(part);
    }
  }
  std::sort(largest.begin(), largest.end());
  return largest;
}

}  // namespace

PartByArea largest_part(const Adjacency& adjacency, Poll& poll) {
  PartByArea part;
  part.vertices = vertices_of_largest_part(adjacency, poll);
  part.weights.assign(part.size(), 0);
  for (std::size_t i = 0; i < part.size(); ++i) {
    for (const std::uint32_t corner : adjacency.corners(part.vertices[i])) {
      if (poll.cancelled()) return part;
      part.weights[i] += std::max(0.0, adjacency.face(face_of(corner)).area2);
    }
  }
  part.sum_weights();
  return part;
}

void PartByArea::sum_weights() {
  all_weight = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (all_weight > 0) return;
  weights.assign(size(), 1);
  all_weight = static_cast<double>(size());
}

tl::unexpected<Error> no_vertex_of_file() {
  return fail(ErrorCode::value_out_of_range, "no vertex of the file is on what is left", "within");
}

DrawByArea::DrawByArea(const PartByArea& part)
    : random_(std::bit_cast<std::uint64_t>(part.all_weight)),
      chances_(part.weights.begin(), part.weights.end()) {}

double standard_errors_of_interval(std::uint64_t draws) {
  constexpr std::array<double, 10> kFew{12.706, 4.303, 3.182, 2.776, 2.571,
                                        2.447,  2.365, 2.306, 2.262, 2.228};
  // Fisher's expansion about the normal distribution (Abramowitz and Stegun 1964, 26.7.5).
  constexpr double z = 1.959963984540054;
  const std::uint64_t freedom = draws - 1;
  if (freedom <= kFew.size()) return kFew[freedom - 1];
  const auto n = static_cast<double>(freedom);
  return z + (z * z * z + z) / (4 * n) +
         (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * n * n) +
         (3 * std::pow(z, 7) + 19 * std::pow(z, 5) + 17 * z * z * z - 15 * z) / (384 * n * n * n);
}

}  // namespace geodesic
