// All methods on a tiny mesh, held against one another: two exact ones that share
// nothing, and what each of the others promises.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/locate/plane_section.h"
#include "core/paths/join_paths.h"
#include "core/paths/trace_path.h"
#include "core/solve/solve_field.h"
#include "core/straighten/log_map.h"
#include "core/straighten/loop_straightness.h"
#include "core/straighten/tighten_loop.h"
#include "core/voronoi/voronoi.h"
#include "tests/fuzz/small_soup.h"

namespace geodesic::fuzz {
namespace {

// Relative to a distance, and to the size of the mesh.
constexpr double kRounding = 1e-7;
constexpr double kOfSize = 1e-9;

Field field_of(Method method, const Adjacency& adjacency, const Source& source) {
  SolveScratch scratch;
  auto field = solve_field(method, {}, adjacency, {&source, 1}, {}, scratch, Cancel());
  expect(field.has_value(), "every mesh has a field");
  return std::move(*field);
}

// Each vertex that a path leads to has its place, unless the faces at the source are no fan.
void check_log_map(const Adjacency& adjacency, const Field& exact, const SurfacePoint& from,
                   double slack) {
  const auto map = log_map(adjacency, exact, from, kUnreached, Cancel(), 0.5);
  if (!map) {
    expect(map.error().code == ErrorCode::value_out_of_range, "only a point without a fan");
    return;
  }
  expect(map->entries.size() == exact.reached, "a place for each vertex that is reached");
  const double least = map->all_round ? 0 : -map->total_angle;
  for (const LogMap::Entry& entry : map->entries) {
    const double d = exact.distance[entry.vertex];
    expect(entry.distance >= d * (1 - kRounding) - slack, "no path is shorter than the shortest");
    expect(entry.angle >= least && entry.angle <= map->total_angle, "an angle round the point");
    const Vec2 at = map->coordinates(entry, 0.5);
    expect(std::abs(norm(at) - entry.distance) <= kRounding * entry.distance,
           "a place so far away");
  }
  expect(map->directions.size() == map->entries.size(), "a direction for each place");
  for (const Vec3& direction : map->directions) {
    const double length = norm(direction);
    expect(length == 0 || std::abs(length - 1) <= kRounding, "of length one, or none");
  }
}

// The cells of two sites and of one of them again add up to the surface that they reach.
void check_cells(const Adjacency& adjacency, const SurfacePoint& from) {
  const std::array<Source, 3> sites{{{from, 0}, {point_at_vertex(adjacency, 0), 0}, {from, 0}}};
  SolveScratch scratch;
  const auto field = solve_field(Method::exact, {}, adjacency, sites, {}, scratch, Cancel());
  expect(field.has_value(), "every mesh has a field");
  const auto found = voronoi(Method::exact, {}, adjacency, *field, 1'000'000, scratch, Cancel());
  expect(found.has_value(), "every mesh has cells");
  double reached = 0;
  for (const FaceRecord& face : adjacency.faces()) {
    const bool is_reached = std::all_of(face.vertex.begin(), face.vertex.end(),
                                        [&](auto v) { return field->distance[v] != kUnreached; });
    if (is_reached) reached += face.area2 / 2;
  }
  double sum = 0;
  for (const VoronoiCell& cell : found->cells) sum += cell.area;
  expect(std::abs(sum - reached) <= kRounding * reached, "cells add up to the surface");
  for (const Bisector& line : found->bisectors.lines) {
    expect(line.points.size() > 1 && std::isfinite(line.length), "a line has two points");
  }
}

// Whatever a loop begins as, it ends closed and no longer, or contracts.
void check_loop(const Adjacency& adjacency, const Path& start, double slack) {
  const auto tight = tighten_loop(adjacency, start, Cancel());
  if (!tight) {
    expect(tight.error().code == ErrorCode::no_loop, "only a loop that contracts");
    return;
  }
  const Path& loop = tight->path;
  expect(!loop.points.empty(), "a loop has points");
  expect(distance(loop.points.front().position, loop.points.back().position) <= slack,
         "a loop is closed");
  expect(loop.length <= start.length, "no loop becomes longer");
  const auto straightness = straightness_of_loop(adjacency, loop, Cancel());
  expect(straightness && straightness->turn >= 0 && straightness->lack >= 0, "a loop has turns");
}

// Through three vertices, and where a plane cuts the surface at one of them.
void check_loops(const Adjacency& adjacency, std::uint32_t first, std::uint8_t which,
                 double slack) {
  const Mesh& mesh = adjacency.mesh();
  const Triangle& others = mesh.faces()[which / 3U % mesh.face_count()];
  std::vector<Path> legs;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t from = i == 0 ? first : others[i - 1];
    const std::uint32_t to = i == 2 ? first : others[i];
    const Field field =
        field_of(Method::dijkstra, adjacency, {point_at_vertex(adjacency, from), 0});
    auto leg = trace_path(adjacency, field, point_at_vertex(adjacency, to), Cancel());
    if (!leg || !*leg) break;
    legs.push_back(std::move(**leg));
  }
  if (legs.size() == 3) check_loop(adjacency, join_paths(legs), slack);
  const Vec3 normal{1.0 + which % 3U, 0.5 - which % 5U, 0.25 * (which % 7U)};
  const auto section =
      plane_section(adjacency, point_at_vertex(adjacency, first), normal, Cancel());
  if (section) {
    check_loop(adjacency, closed_path_along(mesh, *section), slack);
  } else {
    expect(section.error().code == ErrorCode::no_loop, "only an open section");
  }
}

}  // namespace

void fuzz_methods(Input input) {
  Reader reader(input);
  const std::uint8_t which = reader.byte();
  const auto mesh = small_mesh(reader);
  if (mesh == nullptr) return;
  const Adjacency adjacency = Adjacency::build(mesh);
  const double size = distance(mesh->box().min, mesh->box().max);
  const std::uint32_t vertex = mesh->faces()[which % mesh->face_count()][which / 64U % 3U];
  const Source source{point_at_vertex(adjacency, vertex), 0};

  const Field exact = field_of(Method::exact, adjacency, source);
  const Field other = field_of(Method::chen_han, adjacency, source);
  const Field edges = field_of(Method::dijkstra, adjacency, source);
  const double slack = kOfSize * size;
  for (std::uint32_t v = 0; v < mesh->vertex_count(); ++v) {
    const double d = exact.distance[v];
    expect(!std::isnan(d), "a distance is a number");
    expect((d == kUnreached) == (edges.distance[v] == kUnreached), "what has a way is reached");
    expect((d == kUnreached) == (other.distance[v] == kUnreached), "by both exact methods");
    if (d == kUnreached) continue;
    expect(std::abs(d - other.distance[v]) <= kRounding * d + slack, "exact methods agree");
    expect(d <= edges.distance[v] * (1 + kRounding) + slack, "no farther than along edges");
    expect(d >= distance(mesh->positions()[v], mesh->positions()[vertex]) * (1 - kRounding) - slack,
           "no nearer than straight");
    const auto path = trace_path(adjacency, exact, point_at_vertex(adjacency, v), Cancel());
    expect(path && *path, "what is reached has a path");
    expect(std::abs((*path)->length - d) <= kRounding * d + slack, "as long as its distance");
  }
  check_log_map(adjacency, exact, source.point, slack);
  check_cells(adjacency, source.point);
  check_loops(adjacency, vertex, which, slack);
  for (const Method method :
       {Method::wavefront, Method::novotni, Method::fast_marching, Method::steiner}) {
    const Field field = field_of(method, adjacency, source);
    for (std::uint32_t v = 0; v < mesh->vertex_count(); ++v) {
      const double d = field.distance[v];
      expect(!std::isnan(d) && d >= 0, "a distance is not negative");
      expect((d == kUnreached) == (exact.distance[v] == kUnreached), "what has a way is reached");
      if (d == kUnreached) continue;
      const auto path = trace_path(adjacency, field, point_at_vertex(adjacency, v), Cancel());
      expect(path && *path, "what is reached has a path");
      expect((*path)->length >= exact.distance[v] * (1 - kRounding) - slack,
             "no path is shorter than the shortest");
    }
  }
}

}  // namespace geodesic::fuzz
