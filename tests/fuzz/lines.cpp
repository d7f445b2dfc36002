// Fields from curves, edges and faces on a tiny mesh, by four methods. Points on the lines bound
// the distances: from above, and less half their spacing from below.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/curves/source_lines.h"
#include "core/solve/curve_lines.h"
#include "core/solve/solve_from_lines.h"
#include "tests/fuzz/small_soup.h"

namespace geodesic::fuzz {
namespace {

// Relative to a distance, and to the size of the mesh.
constexpr double kRounding = 1e-7;
constexpr double kOfSize = 1e-9;
constexpr std::size_t kMostPieces = 10'000;
constexpr int kGapsASegment = 4;
// Of Cancel, for a field by windows on 48 faces.
constexpr std::uint64_t kMostQuestions = 20'000;

struct Question {
  SourceLines lines;
  std::vector<Source> sources;
};

// Four kinds of things: curves, boundaries, faces, points. False where there is nothing of it.
bool add_item(const Adjacency& adjacency, Reader& reader, std::uint32_t item, Question& question) {
  const Cancel never;
  Poll poll(never);
  const std::uint8_t kind = reader.byte();
  const std::size_t before = question.sources.size();
  if (kind % 8 == 0) {
    for (const BoundaryLoop& loop : boundary_loops(adjacency, poll)) {
      add_edges(adjacency, loop.edges, item, question.lines, question.sources, poll);
    }
  } else if (kind % 8 == 1) {
    std::vector<std::uint32_t> faces;
    const auto count = static_cast<std::uint32_t>(adjacency.faces().size());
    for (int i = 0; i < 1 + kind / 64; ++i) faces.push_back(reader.byte() % count);
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    add_faces(adjacency, faces, item, question.lines, question.sources, poll);
  } else if (kind % 8 == 2) {
    question.sources.push_back({small_point(adjacency, reader), 0});
    question.lines.item_of_source.push_back(item);
  } else {
    const bool is_closed = kind >= 192;
    std::vector<SurfacePoint> points;
    const int count = is_closed ? 3 : 2 + kind / 64;
    for (int i = 0; i < count; ++i) points.push_back(small_point(adjacency, reader));
    SolveScratch scratch;
    Question with = question;
    const auto length = add_curve(adjacency, points, is_closed, item, kMostPieces, with.lines,
                                  with.sources, scratch, Cancel());
    if (!length) {
      expect(length.error().code == ErrorCode::no_loop, "only a curve to another component fails");
      return false;
    }
    expect(std::isfinite(*length) && *length >= 0, "a curve has a length");
    question = std::move(with);
  }
  return question.sources.size() > before;
}

Result<Field> field_of(Method method, const Adjacency& adjacency, const Question& question) {
  std::uint64_t asked = 0;
  const Cancel cancel([&] { return ++asked > kMostQuestions; });
  SolveScratch scratch;
  auto field =
      solve_from_lines(method, {}, adjacency, question.sources,
                       std::make_shared<const SourceLines>(question.lines), {}, scratch, cancel);
  expect(field || field.error().code == ErrorCode::too_large, "a field, soon, or too many strips");
  return field;
}

// The field of points on all lines, and of the corners of faces, and how far apart points are.
std::pair<Field, double> field_of_points(const Adjacency& adjacency, const Question& question) {
  std::vector<Source> dense = question.sources;
  double spacing = 0;
  for (const LineSegment& segment : question.lines.segments) {
    SurfacePoint last;
    for (int i = 0; i <= kGapsASegment; ++i) {
      const double part = static_cast<double>(i) / kGapsASegment;
      std::array<double, 3> bary{};
      for (std::size_t c = 0; c < 3; ++c) {
        bary[c] = segment.from[c] + part * (segment.to[c] - segment.from[c]);
      }
      const SurfacePoint point = point_on_face(adjacency, segment.face, bary);
      if (i > 0) {
        spacing = std::max(spacing, distance(position_of(adjacency.mesh(), last),
                                             position_of(adjacency.mesh(), point)));
      }
      dense.push_back({point, 0});
      last = point;
    }
  }
  for (std::uint32_t f = 0; f < adjacency.faces().size(); ++f) {
    if (!question.lines.has_face(f)) continue;
    for (const std::uint32_t v : adjacency.face(f).vertex) {
      dense.push_back({point_at_vertex(adjacency, v), 0});
    }
  }
  SolveScratch scratch;
  auto field = solve_field(Method::exact, {}, adjacency, dense, {}, scratch, Cancel());
  expect(field.has_value(), "every mesh has a field from points");
  return {std::move(*field), spacing};
}

void check_path(const Adjacency& adjacency, const Field& field, std::uint32_t vertex,
                double slack) {
  const auto path = path_from_lines(adjacency, field, point_at_vertex(adjacency, vertex),
                                    PathWork::traced, Cancel());
  expect(path && *path, "what is reached has a path");
  const double d = field.distance[vertex];
  expect(std::abs((*path)->length - d) <= kRounding * d + slack, "as long as its distance");
}

}  // namespace

void fuzz_lines(Input input) {
  Reader reader(input);
  const std::uint8_t items = reader.byte();
  // Before the mesh, which takes all bytes that are left.
  std::vector<std::uint8_t> drawn;
  for (int i = 0; i < 36; ++i) drawn.push_back(reader.byte());
  const auto mesh = small_mesh(reader);
  if (mesh == nullptr) return;
  const Adjacency adjacency = Adjacency::build(mesh);
  const double slack = kOfSize * distance(mesh->box().min, mesh->box().max);

  Question question;
  Reader places(drawn);
  std::uint32_t item = 0;
  for (int i = 0; i <= items % 3; ++i) {
    if (add_item(adjacency, places, item, question)) ++item;
  }
  if (question.sources.empty()) return;
  if (items >= 128) {
    const Cancel never;
    Poll poll(never);
    merge_repeated(adjacency, question.lines, question.sources, poll);
  }
  expect(question.lines.item_of_source.size() == question.sources.size(),
         "each source belongs to an item");

  const auto exact = field_of(Method::exact, adjacency, question);
  const auto other = field_of(Method::chen_han, adjacency, question);
  const auto near = field_of(Method::back_traced, adjacency, question);
  const auto edges = field_of(Method::dijkstra, adjacency, question);
  expect(edges.has_value(), "edges are never too many");
  const auto [points, spacing] = field_of_points(adjacency, question);
  for (std::uint32_t v = 0; v < mesh->vertex_count(); ++v) {
    const double most = points.distance[v];
    expect((edges->distance[v] == kUnreached) == (most == kUnreached), "what has a way is reached");
    for (const auto* field : {&exact, &other, &near}) {
      if (!*field) continue;
      expect(((*field)->distance[v] == kUnreached) == (most == kUnreached),
             "by each method what has a way is reached");
    }
    if (most == kUnreached || !exact) continue;
    const double d = exact->distance[v];
    expect(d <= most * (1 + kRounding) + slack, "no farther than from points of the lines");
    expect(d >= most * (1 - kRounding) - spacing / 2 - slack, "no nearer than points allow");
    expect(d <= edges->distance[v] * (1 + kRounding) + slack, "no farther than along edges");
    if (other) {
      expect(std::abs(d - other->distance[v]) <= kRounding * d + slack, "exact methods agree");
    }
    if (near) {
      expect(near->distance[v] >= d * (1 - kRounding) - slack, "auto is not below the truth");
      expect(near->distance[v] <= d * (1 + kToleranceFromLines) + slack, "nor far above it");
    }
    check_path(adjacency, *exact, v, slack);
  }
}

}  // namespace geodesic::fuzz
