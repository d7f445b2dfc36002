// Lines on heaps of faces: sheets glued at some places, faces that are there again, edges of many
// faces. Strips that parted meet again there, in more ways than could be counted. They end soon,
// and distances are right.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/curves/strip_front.h"
#include "tests/core/curves/curve_fixtures.h"
#include "tests/core/solve/crowded_meshes.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/every_strip.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/glued_sheets.h"
#include "tests/fixtures/sanitizers.h"

using namespace geodesic;
using fixtures::DensePoints;
using fixtures::fraction;
using fixtures::glued_sheets;
using fixtures::LineQuestion;
using fixtures::pairs_of_sheets;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

// Of Cancel, whatever the mesh, and for each of its faces.
constexpr std::uint64_t kMostQuestions = 200;
constexpr std::uint64_t kMostQuestionsAFace = 2;

// Faces of any three of a few points.
TriangleSoup faces_on_few_points(std::mt19937& random) {
  TriangleSoup soup;
  const std::uint32_t points = 5 + random() % 8;
  for (std::uint32_t i = 0; i < points; ++i) {
    soup.positions.push_back({fraction(random), fraction(random), fraction(random)});
  }
  soup.faces.push_back({0, 1, 2});
  for (std::uint32_t f = 20 + random() % 160; f > 0; --f) {
    const auto a = static_cast<std::uint32_t>(random() % points);
    const auto b = static_cast<std::uint32_t>(random() % points);
    soup.faces.push_back({a, b, static_cast<std::uint32_t>(random() % points)});
  }
  return soup;
}

TriangleSoup some_heap(std::mt19937& random) {
  const int faces = 20 + static_cast<int>(random() % 280);
  const auto tenth = [&] { return std::pow(10.0, -static_cast<double>(random() % 9)); };
  switch (random() % 7) {
    case 0:
      return fixtures::faces_thrown_together(random, faces);
    case 1:
      return fixtures::grown(random, faces);
    case 2:
      return fixtures::heap_on_a_line(random, tenth());
    case 3:
      return glued_sheets(random, 0);
    case 4:
      return glued_sheets(random, tenth());
    case 5: {
      TriangleSoup soup = fixtures::dented_ball(random, 1);
      const std::size_t once = soup.faces.size();
      for (std::size_t i = 0; i < once; ++i) soup.faces.push_back(soup.faces[random() % once]);
      return soup;
    }
    default:
      return faces_on_few_points(random);
  }
}

// Each set of corners once, and for each face of the soup its number there.
std::pair<TriangleSoup, std::vector<std::uint32_t>> without_repeated(const TriangleSoup& soup) {
  TriangleSoup once{soup.positions, {}};
  std::vector<std::uint32_t> number;
  std::map<Triangle, std::uint32_t> known;
  for (const Triangle& face : soup.faces) {
    Triangle key = face;
    std::sort(key.begin(), key.end());
    const auto [place, is_new] = known.emplace(key, static_cast<std::uint32_t>(once.faces.size()));
    if (is_new) once.faces.push_back(face);
    number.push_back(place->second);
  }
  return {once, number};
}

// A few faces of the soup, and the lines that cross them: from a corner to the next, or to a place
// on the side opposite.
struct Stroke {
  std::uint32_t face;
  std::array<double, 3> from;
  std::array<double, 3> to;
};

std::vector<Stroke> some_strokes(const Surface& surface, std::mt19937& random) {
  std::vector<Stroke> strokes;
  for (std::uint32_t count = 1 + random() % 3; count > 0; --count) {
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const std::uint32_t c = random() % 3;
    Stroke stroke{surface.mesh().source_of_face(f), {}, {}};
    stroke.from[c] = 1;
    const double part = random() % 2 == 0 ? 0 : fraction(random);
    stroke.to[next_corner(c)] = 1 - part;
    stroke.to[previous_corner(c)] = part;
    strokes.push_back(stroke);
  }
  return strokes;
}

// The same corner of the face in a soup where its corners may be in another order.
std::array<double, 3> turned(const Triangle& face, const std::array<double, 3>& weights,
                             const Triangle& other) {
  std::array<double, 3> same{};
  for (std::uint32_t c = 0; c < 3; ++c) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (other[k] == face[c]) same[k] = weights[c];
    }
  }
  return same;
}

struct NamedMethod {
  const char* name;
  Method method;
  MethodOptions options;
};

std::array<NamedMethod, 4> methods() {
  std::array<NamedMethod, 4> all{{{"exact", Method::exact, {}},
                                  {"chen_han", Method::chen_han, {}},
                                  {"auto", Method::back_traced, {}},
                                  {"upper", Method::back_traced, {}}}};
  all[3].options.bound = Bound::upper;
  return all;
}

// Fails where it asks too often.
Field field_soon(const Surface& surface, const LineQuestion& question, const NamedMethod& by,
                 bool keep_details = true) {
  CAPTURE(by.name);
  const std::uint64_t most = kMostQuestions + kMostQuestionsAFace * surface.mesh().face_count();
  std::uint64_t asked = 0;
  const Cancel cancel([&] { return ++asked > most; });
  FieldLimits limits;
  limits.keep_details = keep_details;
  SolveScratch scratch;
  auto field = solve_from_lines(by.method, by.options, surface.adjacency(), question.sources(),
                                std::make_shared<const SourceLines>(question.lines()), limits,
                                scratch, cancel);
  REQUIRE(field);
  return std::move(*field);
}

// Every strip of faces that an edge's wave goes over straight, in which no face comes twice: how
// near it comes to each vertex. In the unfolded plane the wave goes up, and has come as far as y.
// Exponential.
class EveryStripOfEdge {
 public:
  EveryStripOfEdge(const Surface& surface, std::vector<double>& met)
      : adjacency_(surface.adjacency()), met_(met), crossed_(surface.mesh().face_count(), false) {}

  // False if there are too many.
  [[nodiscard]] bool go_out(std::uint32_t a, std::uint32_t b) {
    const double length = distance(position(a), position(b));
    over(a, b, {0, 0}, {length, 0}, 0, length);
    return steps_ < kMostSteps;
  }

 private:
  static constexpr std::uint64_t kMostSteps = 300'000;
  struct Place {
    double x;
    double y;
  };
  [[nodiscard]] Vec3 position(std::uint32_t v) const { return adjacency_.mesh().positions()[v]; }

  // From the left end of an edge to its right one, by rays between `low` and `high`.
  void over(std::uint32_t left, std::uint32_t right, Place p, Place q, double low, double high) {
    if (!(low < high)) return;
    for (const std::uint32_t corner : adjacency_.corners(left)) {
      const std::uint32_t f = face_of(corner);
      const auto& v = adjacency_.face(f).vertex;
      if (crossed_[f] || std::find(v.begin(), v.end(), right) == v.end()) continue;
      if (++steps_ >= kMostSteps) return;
      const std::uint32_t apex = v[0] + v[1] + v[2] - left - right;
      const Vec3 base = position(right) - position(left);
      const Vec3 side = position(apex) - position(left);
      const double along = dot(base, side) / dot(base, base);
      const double aside = norm(cross(base, side)) / dot(base, base);
      const Place w{p.x + along * (q.x - p.x) - aside * (q.y - p.y),
                    p.y + along * (q.y - p.y) + aside * (q.x - p.x)};
      if (low - 1e-12 <= w.x && w.x <= high + 1e-12) met_[apex] = std::min(met_[apex], w.y);
      crossed_[f] = true;
      over(left, apex, p, w, low, std::min(high, w.x));
      over(apex, right, w, q, std::max(low, w.x), high);
      crossed_[f] = false;
    }
  }

  const Adjacency& adjacency_;
  std::vector<double>& met_;  // by vertex
  std::vector<bool> crossed_;
  std::uint64_t steps_ = 0;
};

TriangleSoup some_small_heap(std::mt19937& random) {
  switch (random() % 4) {
    case 0:
      return fixtures::faces_thrown_together(random, 6 + static_cast<int>(random() % 12));
    case 1:
      return fixtures::grown(random, 6 + static_cast<int>(random() % 20));
    case 2: {
      TriangleSoup soup = faces_on_few_points(random);
      soup.faces.resize(6 + random() % 10);
      return soup;
    }
    default: {
      const double off = std::pow(10.0, -static_cast<double>(random() % 9));
      TriangleSoup soup = pairs_of_sheets(random, 3, off);
      soup.faces.resize(12 + random() % 10);
      return soup;
    }
  }
}

// The oracles do not know faces that are lines.
TriangleSoup with_area(TriangleSoup soup) {
  const auto is_line = [&](const Triangle& face) {
    const Vec3 a = soup.positions[face[0]];
    return norm(cross(soup.positions[face[1]] - a, soup.positions[face[2]] - a)) < 1e-3;
  };
  soup.faces.erase(std::remove_if(soup.faces.begin(), soup.faces.end(), is_line), soup.faces.end());
  return soup;
}

double extent_of(const Surface& surface) {
  return norm(surface.mesh().box().max - surface.mesh().box().min);
}

}  // namespace

TEST_CASE("LinesOnHeapsEndSoonAndAreRight") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    const TriangleSoup soup = some_heap(random);
    const Surface surface(soup);
    const auto distinct = without_repeated(soup);
    const TriangleSoup& once = distinct.first;
    const std::vector<std::uint32_t>& number_once = distinct.second;
    const Surface surface_once(once);
    LineQuestion question(surface);
    LineQuestion question_once(surface_once);
    for (const Stroke& stroke : some_strokes(surface, random)) {
      (void)question.curve(
          {surface.on(stroke.face, stroke.from), surface.on(stroke.face, stroke.to)}, false);
      const std::uint32_t f = number_once[stroke.face];
      const auto there = [&](const std::array<double, 3>& weights) {
        return surface_once.on(f, turned(soup.faces[stroke.face], weights, once.faces[f]));
      };
      (void)question_once.curve({there(stroke.from), there(stroke.to)}, false);
    }
    const DensePoints dense =
        fixtures::dense_points(surface, question.lines(), question.sources(), 12);
    const Field limit = surface.field_by(Method::exact, dense.sources);
    const auto [exact, chen_han, automatic, upper] = methods();
    const Field field = field_soon(surface, question, exact);
    const Field other = field_soon(surface, question, chen_han);
    const Field near = field_soon(surface, question, automatic, random() % 2 == 0);
    const Field above = field_soon(surface, question, upper, random() % 2 == 0);
    const Field of_once = field_soon(surface_once, question_once, exact);
    const double rounding = 1e-9 * extent_of(surface);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      if (limit.distance[v] == kUnreached) {
        CHECK(field.distance[v] == kUnreached);
        continue;
      }
      const double distance = field.distance[v];
      CHECK(distance <= limit.distance[v] + rounding);
      CHECK(distance >= limit.distance[v] - dense.spacing / 2 - rounding);
      CHECK(std::abs(other.distance[v] - distance) <= rounding);
      CHECK(near.distance[v] >= distance - rounding);
      CHECK(near.distance[v] <= distance * (1 + kToleranceFromLines) + rounding);
      CHECK(above.distance[v] >= distance - 1e-3 * rounding);
      CHECK(above.distance[v] <= distance * (1 + kToleranceFromLines) + rounding);
      const std::uint32_t same = surface_once.vertex(surface.mesh().source_of_vertex(v));
      CHECK(std::abs(of_once.distance[same] - distance) <= rounding);
    }
    const PointArrivals arrivals(surface.adjacency(), limit);
    for (int i = 0; i < 20; ++i) {
      const SurfacePoint point = fixtures::some_point(surface, random);
      const double most = arrivals.distance_at(point);
      if (most == kUnreached) continue;
      const double distance = question.at(field, point);
      CHECK(distance <= most + rounding);
      CHECK(distance >= most - dense.spacing / 2 - rounding);
      const auto path = question.path(field, point);
      REQUIRE(path);
      CHECK(std::abs(path->length - distance) <= 10 * rounding);
      CHECK(question.at(field, path->points.front().point) <= rounding);
    }
  }
}

TEST_CASE("EdgesOnSmallHeapsAreAsFarAsByEveryStrip") {
  std::mt19937 random(test_seed());
  int complete = 0;
  for (int round = 0; round < fixtures::all_or(400, 80); ++round) {
    CAPTURE(round);
    const Surface surface(with_area(some_small_heap(random)));
    const std::uint32_t vertices = surface.mesh().vertex_count();
    LineQuestion question(surface);
    std::vector<double> met(vertices, kUnreached);
    bool is_complete = true;
    for (std::uint32_t count = 1 + random() % 2; count > 0; --count) {
      const FaceRecord& face = surface.adjacency().face(random() % surface.mesh().face_count());
      const std::uint32_t c = random() % 3;
      const std::uint32_t a = face.vertex[c];
      const std::uint32_t b = face.vertex[next_corner(c)];
      (void)question.curve(
          {point_at_vertex(surface.adjacency(), a), point_at_vertex(surface.adjacency(), b)},
          false);
      is_complete = EveryStripOfEdge(surface, met).go_out(a, b) && is_complete;
    }
    std::vector<Source> sources = question.sources();
    for (std::uint32_t v = 0; v < vertices; ++v) {
      if (met[v] < kUnreached) {
        sources.push_back({point_at_vertex(surface.adjacency(), v), std::max(met[v], 0.0)});
      }
    }
    const fixtures::EveryStrip every(surface.adjacency(), 300'000);
    if (!is_complete || every.gave_up()) continue;
    ++complete;
    const std::vector<double> truth = every.distances(sources);
    const Field exact = field_soon(surface, question, methods()[0]);
    const Field upper = field_soon(surface, question, methods()[3]);
    const double rounding = 1e-9 * extent_of(surface);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      CAPTURE(v);
      if (truth[v] == kUnreached) continue;
      CHECK(std::abs(exact.distance[v] - truth[v]) <= rounding);
      CHECK(upper.distance[v] >= truth[v] - 1e-3 * rounding);
      CHECK(upper.distance[v] <= truth[v] * (1 + kToleranceFromLines) + rounding);
    }
  }
  CHECK(complete > fixtures::all_or(200, 40));
}

TEST_CASE("SixtyPairsOfSheetsHaveStripsForEachOnce") {
  constexpr std::uint32_t kLines = 60;
  std::mt19937 random(test_seed());
  for (const double off : {0.0, 1e-13, 1e-11, 1e-9}) {
    CAPTURE(off);
    const Surface surface(pairs_of_sheets(random, kLines, off));
    LineQuestion question(surface);
    (void)question.curve({surface.at(0), surface.at(1), surface.at(2), surface.at(3)}, false);
    for (const NamedMethod& by : methods()) {
      const Field field = field_soon(surface, question, by);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        const double x = surface.mesh().positions()[v].x;
        const double most = by.method == Method::back_traced ? 1 + kToleranceFromLines : 1;
        CHECK(field.distance[v] >= x - 1e-9);
        CHECK(field.distance[v] <= most * x + 1e-7);
      }
    }
  }
}

// What parts by the million is refused, and the methods that the error names do without.
TEST_CASE("PairsOfSheetsThatAreNotFlatEndInAFieldOrAnError") {
  std::mt19937 random(test_seed());
  for (const std::uint32_t lines : {6, 40}) {
    if (fixtures::kSanitized && lines == 40) continue;
    CAPTURE(lines);
    const Surface surface(pairs_of_sheets(random, lines, 0.1));
    LineQuestion question(surface);
    (void)question.curve({surface.at(0), surface.at(1), surface.at(2), surface.at(3)}, false);
    const auto ask = [&](Method method) {
      std::uint64_t asked = 0;
      const Cancel cancel([&] { return ++asked > 1'000'000; });
      FieldLimits limits;
      limits.keep_details = false;
      SolveScratch scratch;
      return solve_from_lines(method, {}, surface.adjacency(), question.sources(),
                              std::make_shared<const SourceLines>(question.lines()), limits,
                              scratch, cancel);
    };
    const auto exact = ask(Method::exact);
    if (lines == 6) CHECK(exact.has_value());  // of 40 nearly all are refused
    if (!exact) CHECK(exact.error().code == ErrorCode::too_large);
    for (const Method method : {Method::dijkstra, Method::fast_marching, Method::steiner}) {
      const auto field = ask(method);
      REQUIRE(field);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        const double x = surface.mesh().positions()[v].x;
        CHECK(field->distance[v] >= 0.999 * x);
        CHECK(field->distance[v] <= 1.5 * x + 0.1);
      }
    }
  }
}

// Long thin faces from one sheet to the other, all about the same vertices: a wave goes round these
// again and again, turned a little each time.
TEST_CASE("AWaveGoesRoundTheVertexThatSheetsFarApartShareOnce") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 150; ++round) {
    CAPTURE(round);
    const double off = random() % 2 == 0 ? 0 : std::pow(10.0, -static_cast<double>(random() % 9));
    const Surface surface(glued_sheets(random, off, 20));
    LineQuestion question(surface);
    for (const Stroke& stroke : some_strokes(surface, random)) {
      (void)question.curve(
          {surface.on(stroke.face, stroke.from), surface.on(stroke.face, stroke.to)}, false);
    }
    const Field field = field_soon(surface, question, methods()[0]);
    const DensePoints dense =
        fixtures::dense_points(surface, question.lines(), question.sources(), 12);
    const Field limit = surface.field_by(Method::exact, dense.sources);
    const double rounding = 1e-9 * extent_of(surface);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      if (limit.distance[v] == kUnreached) continue;
      CHECK(field.distance[v] <= limit.distance[v] + rounding);
      CHECK(field.distance[v] >= limit.distance[v] - dense.spacing / 2 - rounding);
    }
  }
}

// The first faces of all pages of a book, or of all but one.
TEST_CASE("ACrowdedEdgeIsInTheBorderOfFacesOnceAndGoneRoundOnce") {
  constexpr std::uint32_t kPages = 2000;
  std::mt19937 random(test_seed());
  const Surface surface(crowded::book(kPages, 1));
  const Adjacency& adjacency = surface.adjacency();
  const std::uint32_t left_out = random() % kPages;
  for (const bool are_all : {false, true}) {
    CAPTURE(are_all);
    std::vector<std::uint32_t> faces;
    for (std::uint32_t p = 0; p < kPages; ++p) {
      if (are_all || p != left_out) faces.push_back(surface.mesh().face_of_source(2 * p));
    }
    std::sort(faces.begin(), faces.end());
    std::uint64_t asked = 0;
    const Cancel cancel([&] { return ++asked == 0; });
    Poll poll(cancel);
    SourceLines lines;
    std::vector<Source> sources;
    add_faces(adjacency, faces, 0, lines, sources, poll);
    // Beyond another edge of each there is the page's second face.
    const std::size_t border = faces.size() + (are_all ? 0 : 1);
    CHECK(lines.segments.size() == border);
    const auto on_spine = [&](const LineSegment& segment) {
      const Halfedge h = segment.along();
      return std::minmax({adjacency.tail(h), adjacency.head(h)}) ==
             std::minmax({surface.vertex(0), surface.vertex(1)});
    };
    CHECK(std::count_if(lines.segments.begin(), lines.segments.end(), on_spine) ==
          (are_all ? 0 : 1));
    merge_repeated(adjacency, lines, sources, poll);
    CHECK(lines.segments.size() == border);
    // The square of the pages is a thousand questions.
    CHECK(asked < 20);
  }
}

TEST_CASE("MoreStripsThanAllowedAreAnErrorOrTheStripsSoFar") {
  std::mt19937 random(test_seed());
  const Surface surface(glued_sheets(random, 0.1));
  LineQuestion question(surface);
  const std::uint32_t f = random() % surface.mesh().face_count();
  (void)question.curve({surface.on(f, {1, 0, 0}), surface.on(f, {0, 0.5, 0.5})}, false);
  const auto lines = std::make_shared<const SourceLines>(question.lines());
  StripLimits limits;
  limits.most = 2;
  const auto few = spread_strips(surface.adjacency(), question.sources(), lines, limits, Cancel());
  REQUIRE(few);
  CHECK_FALSE(few->is_complete);
  limits.fail_beyond = true;
  const auto none = spread_strips(surface.adjacency(), question.sources(), lines, limits, Cancel());
  REQUIRE(!none);
  CHECK(none.error().code == ErrorCode::too_large);
  CHECK(none.error().limit == 2);
  CHECK(none.error().detail.find("points as sources") != std::string::npos);
  limits.most = 100 * surface.mesh().face_count();
  const auto all = spread_strips(surface.adjacency(), question.sources(), lines, limits, Cancel());
  REQUIRE(all);
  CHECK(all->is_complete);
}
