#include "core/extent/extent.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/extent/mean_distances.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;
using std::numbers::pi;

namespace {

constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();
constexpr ExtentOf kMeasures[] = {ExtentOf::diameter, ExtentOf::center, ExtentOf::median,
                                  ExtentOf::mean};

Extent extent_of(const Surface& surface, ExtentOf what, std::uint64_t fields,
                 Method method = Method::exact) {
  SolveScratch scratch;
  auto found = extent(what, method, {}, surface.adjacency(), fields, scratch, Cancel());
  REQUIRE(found);
  return std::move(*found);
}

MeanDistances means_of(const Surface& surface, std::uint64_t fields,
                       Method method = Method::exact) {
  SolveScratch scratch;
  auto found = mean_distances(method, {}, surface.adjacency(), fields, scratch, Cancel());
  REQUIRE(found);
  return std::move(*found);
}

// The oracle: all fields, and the definitions, on the part with most vertices. A vertex weighs as
// much as the faces at it.
struct AllPairs {
  AllPairs(const Surface& surface, Method method) {
    const std::uint32_t count = surface.mesh().vertex_count();
    std::vector<double> weight(count, 0);
    const auto p = surface.mesh().positions();
    for (const Triangle& t : surface.mesh().faces()) {
      const double area = norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 2;
      for (const std::uint32_t v : t) weight[v] += area;
    }
    std::vector<Field> fields;
    std::vector<std::uint64_t> reached;
    for (std::uint32_t v = 0; v < count; ++v) {
      fields.push_back(surface.field_by(method, {{point_at_vertex(surface.adjacency(), v), 0}}));
      reached.push_back(fields.back().reached);
    }
    const auto first = static_cast<std::size_t>(std::max_element(reached.begin(), reached.end()) -
                                                reached.begin());
    part_vertices = reached[first];
    farthest.assign(count, -1);
    mean.assign(count, -1);
    double all = 0;
    for (std::uint32_t v = 0; v < count; ++v) {
      if (fields[first].distance[v] != kUnreached) all += weight[v];
    }
    for (std::uint32_t v = 0; v < count; ++v) {
      if (fields[first].distance[v] == kUnreached) continue;
      farthest[v] = fields[v].max;
      mean[v] = 0;
      for (std::uint32_t u = 0; u < count; ++u) {
        const double d = fields[v].distance[u];
        if (d != kUnreached) mean[v] += weight[u] / all * d;
      }
      mean_of_all += weight[v] / all * mean[v];
    }
  }
  [[nodiscard]] double value(ExtentOf what) const {
    const auto least = [](const std::vector<double>& of) {
      double found = std::numeric_limits<double>::infinity();
      for (const double value : of) found = value >= 0 ? std::min(found, value) : found;
      return found;
    };
    if (what == ExtentOf::diameter) return *std::max_element(farthest.begin(), farthest.end());
    if (what == ExtentOf::center) return least(farthest);
    if (what == ExtentOf::median) return least(mean);
    return mean_of_all;
  }
  std::vector<double> farthest;  // by vertex; -1 outside of the part
  std::vector<double> mean;
  std::uint64_t part_vertices = 0;
  double mean_of_all = 0;
};

void check_against(const AllPairs& all, const Surface& surface, ExtentOf what, const Extent& found,
                   Method method) {
  const double truth = all.value(what);
  const double small = 1e-8 * truth;
  CHECK(found.lower <= found.value);
  CHECK(found.value <= found.upper);
  if (what != ExtentOf::mean) {
    CHECK(found.lower <= truth + small);
    CHECK(found.upper >= truth - small);
  }
  if (found.is_exact) CHECK(std::abs(found.value - truth) <= small);
  if (what == ExtentOf::diameter) {
    REQUIRE(found.vertices.size() == 2);
    const Field field =
        surface.field_by(method, {{point_at_vertex(surface.adjacency(), found.vertices[0]), 0}});
    CHECK(field.distance[found.vertices[1]] == doctest::Approx(found.value).epsilon(1e-9));
  } else if (what == ExtentOf::center) {
    CHECK(std::abs(all.farthest[found.vertices[0]] - found.value) <= small);
  } else if (what == ExtentOf::median) {
    CHECK(std::abs(all.mean[found.vertices[0]] - found.value) <= small);
  } else {
    CHECK(found.vertices.empty());
  }
}

}  // namespace

TEST_CASE("ExtentsAreThoseOfAllPairs") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < fixtures::all_or(12, 3); ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const std::uint32_t count = surface.mesh().vertex_count();
    const Method method = i % 2 == 0 ? Method::exact : Method::dijkstra;
    const AllPairs all(surface, method);
    for (const ExtentOf what : kMeasures) {
      CAPTURE(static_cast<int>(what));
      for (const std::uint64_t fields : {std::uint64_t{1}, 2 + random() % 9, kAll}) {
        CAPTURE(fields);
        const Extent found = extent_of(surface, what, fields, method);
        CHECK(found.fields <= std::min<std::uint64_t>(fields, count));
        CHECK(found.part_vertices == all.part_vertices);
        if (fields == kAll) CHECK(found.is_exact);
        check_against(all, surface, what, found, method);
      }
    }
  }
}

TEST_CASE("ExtentsOfAwkwardSurfacesAreThoseOfAllPairs") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    if (mesh.name == "two components") continue;
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    const AllPairs all(surface, Method::exact);
    for (const ExtentOf what : kMeasures) {
      for (const std::uint64_t fields : {std::uint64_t{3}, kAll}) {
        check_against(all, surface, what, extent_of(surface, what, fields), Method::exact);
      }
    }
  }
}

// On an uneven surface few fields leave no doubt.
TEST_CASE("FewFieldsSufficeForTheDiameterAndTheCenter") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 4; ++i) {
    const Surface surface(shapes::terrain(30, 5, static_cast<std::uint32_t>(random())));
    for (const ExtentOf what : {ExtentOf::diameter, ExtentOf::center}) {
      const Extent found = extent_of(surface, what, kAll);
      CHECK(found.is_exact);
      CHECK(found.fields < 300);
    }
  }
  const Surface strip(shapes::plane(61, 3));
  const Extent diameter = extent_of(strip, ExtentOf::diameter, kAll);
  CHECK(diameter.value == doctest::Approx(std::hypot(60, 2)));
  CHECK(diameter.fields < 60);
  const Extent center = extent_of(strip, ExtentOf::center, kAll);
  CHECK(center.value == doctest::Approx(std::hypot(30, 1)));
  CHECK(strip.mesh().source_of_vertex(center.vertices[0]) == 61 + 30);
  CHECK(center.fields < 60);
  const Extent median = extent_of(strip, ExtentOf::median, 60);
  CHECK(strip.mesh().source_of_vertex(median.vertices[0]) == 61 + 30);
}

TEST_CASE("OfASphereEveryVertexIsTheMiddle") {
  const Surface surface(shapes::icosphere(3));
  const Extent diameter = extent_of(surface, ExtentOf::diameter, 20);
  CHECK(diameter.value == doctest::Approx(pi).epsilon(0.02));
  CHECK(diameter.upper < 2 * pi);
  const Extent center = extent_of(surface, ExtentOf::center, 20);
  CHECK(center.value == doctest::Approx(pi).epsilon(0.03));
  CHECK(center.lower > pi / 2);
  const Extent mean = extent_of(surface, ExtentOf::mean, 50);
  CHECK(mean.value == doctest::Approx(pi / 2).epsilon(0.01));
  CHECK_FALSE(mean.is_exact);
}

// Points of a unit square are 0.5214 apart on average (Philip 2007).
TEST_CASE("TheMeanOfASquareIsKnown") {
  const Surface surface(shapes::plane(21, 21));
  const Extent whole = extent_of(surface, ExtentOf::mean, kAll);
  CHECK(whole.is_exact);
  CHECK(whole.value / 20 == doctest::Approx(0.521405).epsilon(0.003));
}

TEST_CASE("MeanDistancesAreThoseOfAllPairs") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 12; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const AllPairs all(surface, Method::exact);
    const MeanDistances found = means_of(surface, kAll);
    CHECK(found.is_exact);
    CHECK(found.part_vertices == all.part_vertices);
    CHECK(found.overall == doctest::Approx(all.mean_of_all).epsilon(1e-8));
    CHECK(found.lower == found.overall);
    CHECK(found.upper == found.overall);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (all.mean[v] < 0) {
        CHECK(found.mean[v] == kUnreached);
        CHECK(found.margin[v] == kUnreached);
      } else {
        CHECK(found.mean[v] == doctest::Approx(all.mean[v]).epsilon(1e-8));
        CHECK(found.margin[v] == 0);
      }
    }
    // Which vertex has the least of them is what the median is.
    const Extent median = extent_of(surface, ExtentOf::median, kAll);
    CHECK(*std::min_element(found.mean.begin(), found.mean.end()) ==
          doctest::Approx(median.value).epsilon(1e-8));
  }
}

// Neighbours are right or wrong together, so many surfaces are asked.
TEST_CASE("MostVerticesHaveTheirMeanWithinTheMargin") {
  std::mt19937 random(test_seed());
  constexpr int kSurfaces = 60;
  for (const std::uint64_t fields : {5, 40}) {
    CAPTURE(fields);
    double inside = 0;
    for (int i = 0; i < kSurfaces; ++i) {
      const Surface surface(shapes::terrain(11, 4, static_cast<std::uint32_t>(random())));
      const MeanDistances truth = means_of(surface, kAll, Method::dijkstra);
      const MeanDistances found = means_of(surface, fields, Method::dijkstra);
      CHECK_FALSE(found.is_exact);
      CHECK(found.fields <= fields);
      CHECK(found.mean.size() == truth.mean.size());
      for (std::size_t v = 0; v < truth.mean.size(); ++v) {
        CHECK(found.margin[v] > 0);
        if (std::abs(found.mean[v] - truth.mean[v]) <= found.margin[v]) ++inside;
      }
    }
    const double share = inside / (kSurfaces * 121);
    CHECK(share > 0.85);
    CHECK(share < 0.995);  // nor are margins as wide as to say nothing
  }
  const Surface surface(shapes::terrain(11, 4, 1));
  const MeanDistances one = means_of(surface, 1);
  CHECK(one.fields == 1);
  CHECK(one.margin[0] == kUnreached);
  CHECK(one.upper == kUnreached);
}

TEST_CASE("MeanDistancesOfAwkwardSurfacesAreFiniteOrUnreached") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    for (const std::uint64_t fields : {std::uint64_t{3}, kAll}) {
      const MeanDistances found = means_of(surface, fields);
      for (const double mean : found.mean) CHECK(mean >= 0);
      for (const double margin : found.margin) CHECK(margin >= 0);
    }
  }
}

TEST_CASE("MeanDistancesAreStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(3));
  for (const std::uint64_t fields : {std::uint64_t{20}, kAll}) {
    for (const std::size_t most : {0U, 3U, 20U}) {
      std::size_t asked = 0;
      const Cancel counting([&] { return ++asked > most; });
      SolveScratch scratch;
      const auto found =
          mean_distances(Method::wavefront, {}, surface.adjacency(), fields, scratch, counting);
      REQUIRE_FALSE(found.has_value());
      CHECK(found.error().code == ErrorCode::cancelled);
    }
  }
}

// On one surface the same vertices are drawn each time, so surfaces differ here.
TEST_CASE("OfTwentyIntervalsAboutNineteenHaveTheMean") {
  std::mt19937 random(test_seed());
  int inside = 0;
  constexpr int kSurfaces = fixtures::all_or(60, 10);
  for (int i = 0; i < kSurfaces; ++i) {
    const Surface surface(shapes::terrain(13, 4, static_cast<std::uint32_t>(random())));
    const double truth = extent_of(surface, ExtentOf::mean, kAll, Method::dijkstra).value;
    const Extent found = extent_of(surface, ExtentOf::mean, 40, Method::dijkstra);
    CHECK(found.value == doctest::Approx(truth).epsilon(0.2));
    if (found.lower <= truth && truth <= found.upper) ++inside;
  }
  CHECK(inside >= kSurfaces * fixtures::all_or(3, 2) / 4);
}

TEST_CASE("OfFewDrawsTheIntervalIsWideOrHasNoEnd") {
  std::mt19937 random(test_seed());
  constexpr int kSurfaces = fixtures::all_or(80, 10);
  for (const std::uint64_t fields : {2, 3, 5}) {
    CAPTURE(fields);
    int inside = 0;
    for (int i = 0; i < kSurfaces; ++i) {
      const Surface surface(shapes::terrain(9, 4, static_cast<std::uint32_t>(random())));
      const double truth = extent_of(surface, ExtentOf::mean, kAll, Method::dijkstra).value;
      const Extent found = extent_of(surface, ExtentOf::mean, fields, Method::dijkstra);
      if (found.fields < 2) CHECK(found.upper == std::numeric_limits<double>::infinity());
      if (found.lower <= truth && truth <= found.upper) ++inside;
    }
    // By the normal distribution it would be two in three with two fields.
    CHECK(inside >= kSurfaces * fixtures::all_or(3, 2) / 4);
  }
}

TEST_CASE("MoreFieldsAreNeverWorseForTheMiddle") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 6; ++i) {
    const Surface surface(shapes::terrain(20, 8, static_cast<std::uint32_t>(random())));
    double last = std::numeric_limits<double>::infinity();
    for (const std::uint64_t fields : {1, 2, 3, 5, 8, 13, 40, 100}) {
      CAPTURE(fields);
      const Extent found = extent_of(surface, ExtentOf::median, fields, Method::dijkstra);
      CHECK(found.value <= last);
      last = found.value;
    }
  }
}

TEST_CASE("OfSeveralPartsTheOneWithMostVerticesIsMeasured") {
  TriangleSoup soup = shapes::plane(30, 2);
  const TriangleSoup other = shapes::plane(9, 9);
  for (Vec3 p : other.positions) soup.positions.push_back(p + Vec3{0, 50, 0});
  for (const auto& t : other.faces) soup.faces.push_back({t[0] + 60, t[1] + 60, t[2] + 60});
  soup.positions.push_back({500, 0, 0});  // in no face
  const Surface surface(soup);
  const Extent found = extent_of(surface, ExtentOf::diameter, kAll);
  CHECK(found.value == doctest::Approx(std::hypot(8, 8)));
  CHECK(found.part_vertices == 81);
  CHECK(found.is_exact);
}

TEST_CASE("ByAMethodThatIsNoMetricOnlyAllFieldsAreExact") {
  const Surface surface(shapes::terrain(12, 3, 4));
  CHECK_FALSE(extent_of(surface, ExtentOf::diameter, 40, Method::wavefront).is_exact);
  const Extent all = extent_of(surface, ExtentOf::diameter, kAll, Method::wavefront);
  CHECK(all.is_exact);
  CHECK(all.fields == 144);
}

// Of the greatest distance from a vertex that no field has reached nothing is known.
TEST_CASE("BoundsAreMetWhereBothAreFiniteAndEqualToRounding") {
  std::mt19937 random(test_seed());
  const double lower =
      std::ldexp(1 + random() / 4294967296.0, static_cast<int>(random() % 60) - 30);
  CAPTURE(lower);
  CHECK(are_met(lower, lower));
  CHECK(are_met(lower, lower * (1 + 1e-12)));
  CHECK_FALSE(are_met(lower, lower * (1 + 1e-6)));
  CHECK_FALSE(are_met(lower, std::numeric_limits<double>::infinity()));
  CHECK(are_met(0, 0));
}

TEST_CASE("AnExtentIsTheSameTwice") {
  const Surface surface(shapes::terrain(15, 3, 4));
  for (const ExtentOf what : kMeasures) {
    const Extent one = extent_of(surface, what, 12);
    const Extent two = extent_of(surface, what, 12);
    CHECK(one.value == two.value);
    CHECK(one.lower == two.lower);
    CHECK(one.upper == two.upper);
    CHECK(one.vertices == two.vertices);
  }
}

TEST_CASE("AnExtentIsStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(3));
  for (const ExtentOf what : kMeasures) {
    for (const std::size_t most : {0U, 3U, 40U}) {
      std::size_t asked = 0;
      const Cancel counting([&] { return ++asked > most; });
      SolveScratch scratch;
      const auto found =
          extent(what, Method::wavefront, {}, surface.adjacency(), kAll, scratch, counting);
      REQUIRE_FALSE(found.has_value());
      CHECK(found.error().code == ErrorCode::cancelled);
    }
  }
}
