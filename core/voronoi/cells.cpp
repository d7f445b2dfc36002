#include "core/voronoi/cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/field/nearest_copies.h"
#include "core/locate/closest_on_triangle.h"
#include "core/voronoi/face_cells.h"

namespace geodesic {
namespace {

using Weights3 = std::array<double, 3>;

Weights3 blend(const Weights3& a, const Weights3& b, double part) {
  Weights3 blended;
  for (std::size_t c = 0; c < 3; ++c) blended[c] = (1 - part) * a[c] + part * b[c];
  return blended;
}

class CellMeasure {
 public:
  CellMeasure(const Adjacency& adjacency, const NearSites& near, std::uint32_t sites, Poll& poll)
      : adjacency_(adjacency),
        near_(near),
        poll_(poll),
        origin_(adjacency.mesh().box().min),
        cells_(sites),
        nearest2_(sites, std::numeric_limits<double>::infinity()),
        place_(sites),
        total_(2 * std::uint64_t{adjacency.mesh().face_count()}) {}

  // Of no use if the poll says to stop.
  std::vector<VoronoiCell> measure() {
    each_part([&](std::uint32_t f, const CellPart& part) { add(f, part); });
    for (VoronoiCell& cell : cells_) {
      if (!cell.is_empty()) cell.mean = origin_ + (1 / cell.area) * cell.mean;
    }
    each_part([&](std::uint32_t f, const CellPart& part) { approach(f, part); });
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].is_empty() || poll_.stopped()) continue;
      // It may be a source next (relax_sites).
      cells_[i].centroid = snapped_point(adjacency_, place_[i].face, place_[i].bary);
    }
    count_vertices();
    return std::move(cells_);
  }

 private:
  template <class Visit>
  void each_part(Visit visit) {
    FaceCells face_cells(adjacency_, near_);
    for (std::uint32_t f = 0; f < adjacency_.mesh().face_count(); ++f) {
      if (poll_.cancelled_after(1, seen_++, total_)) return;
      for (const CellPart& part : face_cells.parts_of(f, poll_)) visit(f, part);
      if (poll_.stopped()) return;
    }
  }

  // As a field has them: a vertex on a wall is in the cell of its nearest side.
  void count_vertices() {
    const Mesh& mesh = adjacency_.mesh();
    const auto square_of = [&](std::uint32_t v) {
      return near_.is_reached(v) ? near_.square(v, near_.nearest(v))
                                 : std::numeric_limits<double>::infinity();
    };
    const auto nearer = nearer_copies(mesh, square_of, poll_);
    for (std::uint32_t v : mesh.vertex_of_source()) {
      if (poll_.cancelled()) return;
      if (const auto copy = nearer.find(v); copy != nearer.end()) v = copy->second;
      if (v != kNone && near_.is_reached(v)) ++cells_[near_.nearest(v)].vertices;
    }
  }

  // The place in space, from the origin of the mesh's box: the digits that there are.
  [[nodiscard]] Vec3 at(std::uint32_t f, const Weights3& weights) const {
    const auto positions = adjacency_.mesh().positions();
    Vec3 sum;
    for (std::size_t c = 0; c < 3; ++c) {
      sum = sum + weights[c] * (positions[adjacency_.face(f).vertex[c]] - origin_);
    }
    return sum;
  }

  void add(std::uint32_t f, const CellPart& part) {
    VoronoiCell& cell = cells_[part.site];
    const double area = adjacency_.face(f).area2 / 2;
    const double share = part.share();
    cell.area += share * area;
    const auto& a = part.corners[0];
    for (std::size_t i = 2; i < part.corners.size(); ++i) {
      const auto& b = part.corners[i - 1];
      const auto& c = part.corners[i];
      const double twice = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
      cell.mean = cell.mean + twice * area / 3 * (at(f, a) + at(f, b) + at(f, c));
    }
  }

  void approach(std::uint32_t f, const CellPart& part) {
    if (cells_[part.site].is_empty()) return;
    const Vec3 mean = cells_[part.site].mean - origin_;
    const std::size_t count = part.corners.size();
    for (std::size_t i = 2; i < count; ++i) {
      const std::array<Weights3, 3> corners{part.corners[0], part.corners[i - 1], part.corners[i]};
      const std::array<Vec3, 3> p{at(f, corners[0]), at(f, corners[1]), at(f, corners[2])};
      const auto foot = foot_inside(mean, p);
      if (!foot) continue;
      Weights3 weights{0, 0, 0};
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 3; ++k) weights[k] += (*foot)[c] * corners[c][k];
      }
      take(f, part.site, mean, weights);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Weights3& a = part.corners[i];
      const Weights3& b = part.corners[(i + 1) % count];
      take(f, part.site, mean, blend(a, b, foot_on_segment(mean, at(f, a), at(f, b))));
    }
  }

  void take(std::uint32_t f, std::uint32_t site, Vec3 mean, const Weights3& weights) {
    const Vec3 off = at(f, weights) - mean;
    const double off2 = dot(off, off);
    if (!(off2 < nearest2_[site])) return;
    nearest2_[site] = off2;
    place_[site] = {f, weights};
  }

  struct Place {
    std::uint32_t face = kNone;
    Weights3 bary{};
  };
  const Adjacency& adjacency_;
  const NearSites& near_;
  Poll& poll_;
  const Vec3 origin_;
  std::vector<VoronoiCell> cells_;
  std::vector<double> nearest2_;
  std::vector<Place> place_;
  const std::uint64_t total_;
  std::uint64_t seen_ = 0;
};

}  // namespace

Result<std::vector<VoronoiCell>> measure_cells(const Adjacency& adjacency, const NearSites& near,
                                               std::uint32_t sites, const Cancel& cancel) {
  Poll poll(cancel);
  auto cells = CellMeasure(adjacency, near, sites, poll).measure();
  if (poll.stopped()) return fail_stopped(poll);
  return cells;
}

}  // namespace geodesic
