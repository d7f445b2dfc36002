// The vertices of a surface's largest part, each with the area about it, for means over the surface
// and their estimates from vertices drawn at random.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The part, joined through vertices, that has most of the file's vertices; the first of several.
struct PartByArea {
  std::vector<std::uint32_t> vertices;  // ascending
  // By place in `vertices`: the area of the vertex's faces, up to one factor; or 1, if no vertex
  // has any.
  std::vector<double> weights;
  double all_weight = 0;  // above 0

  // Makes `all_weight` of the weights, or these 1.
  void sum_weights();
  [[nodiscard]] std::size_t size() const { return vertices.size(); }
  // So that the mean over the area of what is linear inside each face is the sum over the vertices
  // of share times value.
  [[nodiscard]] double share_of(std::size_t place) const { return weights[place] / all_weight; }
};

// Whether it is a vertex of the file: not one that lines have made, and of those that walls have
// doubled the first.
[[nodiscard]] bool is_of_file(const Mesh& mesh, std::uint32_t vertex);

// Of no use if the poll says to stop.
[[nodiscard]] PartByArea largest_part(const Adjacency& adjacency, Poll& poll);

// Places drawn by their weights, each as often as it comes: the same each time, so that an answer
// is, but others on another surface.
class DrawByArea {
 public:
  explicit DrawByArea(const PartByArea& part);
  [[nodiscard]] std::size_t next() { return chances_(random_); }

 private:
  std::mt19937_64 random_;
  std::discrete_distribution<std::size_t> chances_;
};

// Where the largest part has none of the file's vertices. value_out_of_range
[[nodiscard]] tl::unexpected<Error> no_vertex_of_file();

// So many standard errors of the mean of a sample of `draws`, two or more, to either side have a
// confidence of 95 %: Student's t distribution. Off by less than 2e-4.
[[nodiscard]] double standard_errors_of_interval(std::uint64_t draws);

}  // namespace geodesic
