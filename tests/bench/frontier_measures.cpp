#include "tests/bench/frontier_measures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "core/extent/mean_distances.h"
#include "core/field/longest_edge.h"
#include "core/locate/plane_section.h"
#include "core/paths/strips.h"
#include "core/refine/faces_inside.h"
#include "core/refine/refine_along.h"
#include "core/solve/curve_lines.h"
#include "core/straighten/log_map.h"
#include "core/straighten/straightest_geodesic.h"
#include "core/voronoi/voronoi.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr std::size_t kMostPieces = 1'000'000;

double area_of(const Mesh& mesh, std::size_t f) {
  const Triangle& face = mesh.faces()[f];
  const auto p = mesh.positions();
  return norm(cross(p[face[1]] - p[face[0]], p[face[2]] - p[face[0]])) / 2;
}

double whole_area(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.faces().size(); ++f) sum += area_of(mesh, f);
  return sum;
}

}  // namespace

Figures means_of_vertices(Asked& asked) {
  constexpr std::uint64_t kFields = 20;
  const auto means = [&](Method method) {
    return take(mean_distances(method, {}, asked.adjacency(), kFields, asked.scratch(), Cancel()));
  };
  MeanDistances found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = means(Method::back_traced); });
  const MeanDistances true_ones = means(Method::exact);
  for (std::size_t v = 0; v < found.mean.size(); ++v) {
    const double mean = true_ones.mean[v];
    if (mean > 0 && mean < kUnreached) {
      figures.off = std::max(figures.off, std::abs(found.mean[v] / mean - 1));
    }
  }
  return figures;
}

Figures strips(Asked& asked) {
  constexpr std::size_t kLevels = 10;
  std::vector<double> levels;
  for (std::size_t i = 0; i <= kLevels; ++i) {
    levels.push_back(asked.farthest() * static_cast<double>(i) / kLevels);
  }
  const auto cut = [&](Method method) {
    const Field field = asked.field(method, kUnreached, false);
    return take(cut_strips(asked.adjacency(), field, levels, Cancel()));
  };
  std::vector<Strip> found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = cut(Method::back_traced); });
  const std::vector<Strip> true_ones = cut(Method::exact);
  for (std::size_t i = 0; i < kLevels; ++i) {
    figures.off = std::max(figures.off, std::abs(found[i].area - true_ones[i].area));
  }
  figures.off /= whole_area(asked.adjacency().mesh());
  return figures;
}

Figures hulls(Asked& asked) {
  const Mesh& mesh = asked.adjacency().mesh();
  const Vec3 normal{1, 0.3, 0.2};
  std::vector<Vec3> section;
  std::vector<std::uint32_t> corners;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    const auto points = plane_section(asked.adjacency(), asked.source().point, normal, Cancel());
    if (!points) return;
    for (const SurfacePoint& point : *points) section.push_back(position_of(mesh, point));
    corners = take(hull_in_plane(section, normal, Cancel()));
  });
  figures.is_there = corners.size() > 2;
  if (!figures.is_there) return figures;
  double length = 0;
  double out = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 begin = section[corners[i]];
    const Vec3 along = section[corners[(i + 1) % corners.size()]] - begin;
    length += norm(along);
    const Vec3 inwards = cross(normal, along);
    for (const Vec3& p : section) out = std::max(out, -dot(inwards, p - begin) / norm(inwards));
  }
  figures.off = out / length;
  return figures;
}

Figures relaxed_sites(Asked& asked) {
  constexpr std::uint32_t kSites = 20;
  constexpr std::uint64_t kRounds = 10;
  const Adjacency& adjacency = asked.adjacency();
  std::vector<Source> sites;
  for (const SurfacePoint& point : asked.connected_points(kSites)) sites.push_back({point, 0});
  Figures figures;
  figures.ms = processor_ms_of([&] {
    sites = take(relax_sites(Method::back_traced, {}, adjacency, std::move(sites), kRounds,
                             asked.scratch(), Cancel()));
  });
  FieldLimits limits;
  limits.keep_details = false;
  const Field field =
      take(solve_field(Method::exact, {}, adjacency, sites, limits, asked.scratch(), Cancel()));
  const Voronoi cells =
      take(voronoi(Method::exact, {}, adjacency, field, kMostPieces, asked.scratch(), Cancel()));
  double area = 0;
  double filled = 0;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (cells.cells[i].is_empty()) continue;
    ++filled;
    area += cells.cells[i].area;
    figures.off += distance(position_of(adjacency.mesh(), sites[i].point),
                            position_of(adjacency.mesh(), cells.cells[i].centroid));
  }
  figures.off /= filled * std::sqrt(area / filled);
  return figures;
}

Figures inside_of_a_curve(Asked& asked) {
  const Adjacency& adjacency = asked.adjacency();
  const std::vector<SurfacePoint> points = asked.connected_points(4);
  SourceLines lines;
  std::vector<Source> sources;
  (void)take(add_curve(adjacency, points, true, 0, kMostPieces, lines, sources, asked.scratch(),
                       Cancel()));
  SurfacePolyline round;
  for (const Source& source : sources) round.push_back(source.point);
  // Nothing where the curve separates nothing.
  const auto area_inside = [&]() -> Result<double> {
    const RefinedMesh refined =
        take(refine_along(adjacency, std::span(&round, 1), kMostPieces, Cancel()));
    const auto mesh = std::make_shared<const Mesh>(refined.mesh);
    const Adjacency split = take(Adjacency::build(mesh, Cancel()));
    const auto inside = faces_inside(split, refined.chains[0], Cancel());
    if (!inside) return fail(inside.error());
    double area = 0;
    for (std::size_t f = 0; f < inside->size(); ++f) {
      if ((*inside)[f] != 0) area += area_of(*mesh, f);
    }
    return area;
  };
  Result<double> found = 0;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = area_inside(); });
  figures.is_there = found.has_value();
  if (!found) return figures;
  std::reverse(round.begin(), round.end());
  figures.off = std::abs(*found - take(area_inside())) / whole_area(adjacency.mesh());
  return figures;
}

Figures carried_directions(Asked& asked) {
  constexpr std::size_t kTried = 500;
  constexpr double kCarried = 1;
  const Adjacency& adjacency = asked.adjacency();
  const SurfacePoint from = point_on_face(adjacency, 0, {1, 1, 1});
  const double radius = 0.1 * asked.farthest();
  FieldLimits limits;
  limits.max = kFieldBeyondRadius * radius + 2 * longest_edge(adjacency);
  const Source source{from, 0};
  LogMap map;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    const Field field = take(solve_field(Method::back_traced, {}, adjacency, {&source, 1}, limits,
                                         asked.scratch(), Cancel()));
    map = take(log_map(adjacency, field, from, radius, Cancel(), kCarried));
  });
  const std::size_t step = map.entries.size() / kTried + 1;
  std::size_t tried = 0;
  for (std::size_t i = 0; i < map.entries.size(); i += step) {
    const LogMap::Entry& entry = map.entries[i];
    const Vec3 carried = map.directions[i];
    if (!entry.is_straight || !(norm(carried) > 0)) continue;
    // Just short of the vertex, in the face in which the path arrives.
    const StraightestGeodesic way = take(straightest_geodesic_at_angle(
        adjacency, from, entry.angle, entry.distance * (1 - 1e-6), Cancel()));
    const double there = dot(carried, way.direction_at_end) / norm(way.direction_at_end);
    const double angle = std::acos(std::clamp(there, -1.0, 1.0));
    const double wanted = std::acos(std::clamp(std::cos(kCarried - entry.angle), -1.0, 1.0));
    figures.off += std::abs(angle - wanted) / std::numbers::pi;
    ++tried;
  }
  figures.is_there = tried > 0;
  if (tried > 0) figures.off /= static_cast<double>(tried);
  return figures;
}

}  // namespace geodesic::bench
