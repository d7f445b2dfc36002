// Slivers by the hundred, as caps of machine parts have them, flipped many times over: the
// intrinsic Delaunay triangulation keeps their surface, and distances on it are right.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/surface/intrinsic_delaunay.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

double uniform(std::mt19937& random, double least, double most) {
  return std::uniform_real_distribution<double>(least, most)(random);
}

// The corners of a convex polygon in the plane, on an ellipse turned by some angle.
std::vector<Vec3> ellipse(std::mt19937& random, std::uint32_t corners, double stretch) {
  const double turn = uniform(random, 0, std::numbers::pi);
  const bool is_even = random() % 2 == 0;
  std::vector<double> angles(corners);
  for (std::uint32_t i = 0; i < corners; ++i) {
    angles[i] = 2 * std::numbers::pi * (is_even ? i / double(corners) : uniform(random, 0, 1));
  }
  std::sort(angles.begin(), angles.end());
  std::vector<Vec3> rim;
  for (const double angle : angles) {
    rim.push_back({std::cos(angle + turn), stretch * std::sin(angle + turn), 0});
  }
  return rim;
}

struct Fan {
  std::string name;
  TriangleSoup soup;
};

// A convex polygon cut into slivers: from a corner, from a point inside, in zigzag, or ear by ear.
Fan flat_fan(std::mt19937& random) {
  const auto corners = static_cast<std::uint32_t>(std::exp(uniform(random, 3, 6.7)));
  Fan fan{"", {}};
  auto& [name, soup] = fan;
  soup.positions = ellipse(random, corners, std::pow(10, uniform(random, 0, 2)));
  const auto face = [&soup = soup](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    soup.faces.push_back({a, b, c});
  };
  switch (random() % 4) {
    case 0:
      name = "from a corner";
      for (std::uint32_t i = 1; i + 1 < corners; ++i) face(0, i, i + 1);
      break;
    case 1: {
      name = "from inside";
      Vec3 inside{};
      for (const Vec3 p : soup.positions) inside = inside + (1.0 / corners) * p;
      inside = inside + uniform(random, 0, 0.9) * (soup.positions[random() % corners] - inside);
      soup.positions.push_back(inside);
      for (std::uint32_t i = 0; i < corners; ++i) face(corners, i, (i + 1) % corners);
      break;
    }
    case 2:
      name = "in zigzag";
      for (std::uint32_t low = 0, high = corners - 1; low + 1 < high;) {
        face(low, low + 1, high);
        ++low;
        if (low + 1 < high) {
          face(low, high - 1, high);
          --high;
        }
      }
      break;
    default: {
      name = "ear by ear";
      std::vector<std::uint32_t> left(corners);
      for (std::uint32_t i = 0; i < corners; ++i) left[i] = i;
      while (left.size() > 2) {
        const std::size_t ear = random() % left.size();
        face(left[(ear + left.size() - 1) % left.size()], left[ear], left[(ear + 1) % left.size()]);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
      }
    }
  }
  name += ", " + std::to_string(corners);
  return fan;
}

// A cylinder over an ellipse, closed by fans from a corner.
TriangleSoup elliptic_cylinder(std::mt19937& random) {
  const auto sides = static_cast<std::uint32_t>(std::exp(uniform(random, 3, 5)));
  const double height = std::pow(10, uniform(random, -1, 1));
  TriangleSoup soup;
  soup.positions = ellipse(random, sides, uniform(random, 1, 20));
  for (std::uint32_t i = 0; i < sides; ++i) {
    soup.positions.push_back(soup.positions[i] + Vec3{0, 0, height});
  }
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    soup.faces.push_back({i, next, sides + next});
    soup.faces.push_back({i, sides + next, sides + i});
  }
  for (std::uint32_t i = 1; i + 1 < sides; ++i) {
    soup.faces.push_back({0, i + 1, i});
    soup.faces.push_back({sides, sides + i, sides + i + 1});
  }
  return soup;
}

}  // namespace

TEST_CASE("EdgesOfAFlatSurfaceAreAsLongAsStraightLinesHoweverOftenTheyAreFlipped") {
  std::mt19937 random(fixtures::test_seed());
  std::size_t flipped = 0;
  for (int round = 0; round < 100; ++round) {
    const Fan fan = flat_fan(random);
    CAPTURE(fan.name);
    const Surface surface(fan.soup);
    const auto positions = surface.mesh().positions();
    const Triangulation cut = surface.adjacency().delaunay();
    if (cut.faces.data() == surface.adjacency().triangulation().faces.data()) continue;
    double worst = 0;
    for (const FaceRecord& face : cut.faces) {
      const double longest = std::sqrt(face.longest2());
      for (std::uint32_t c = 0; c < 3; ++c) {
        const double straight =
            distance(positions[face.vertex[c]], positions[face.vertex[next_corner(c)]]);
        const double length = std::sqrt(std::max(face.length2(c), 0.0));
        // A square of a side far shorter than the others is what two products leave of it.
        const double off = std::abs(length * length - straight * straight) / (longest * longest);
        worst = std::max(worst, off);
      }
      ++flipped;
    }
    CHECK(worst < 1e-14);
  }
  CHECK(flipped > 1000);
}

TEST_CASE("DistancesOverFlatSliversAreStraightLines") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 60; ++round) {
    const Fan fan = flat_fan(random);
    CAPTURE(fan.name);
    const Surface surface(fan.soup);
    const auto source = static_cast<std::uint32_t>(random() % fan.soup.positions.size());
    const std::vector<Source> from{{surface.at(source), 0}};
    const Field exact = surface.field_by(Method::exact, from);
    MethodOptions options;
    options.error_at_most = 1e-4;
    const Field within = surface.field_by(Method::back_traced, from, {}, options);
    options = {};
    options.bound = Bound::upper;
    const Field upper = surface.field_by(Method::back_traced, from, {}, options);
    double worst = 0;
    double beyond = 0;
    double below = 0;
    for (std::uint32_t i = 0; i < fan.soup.positions.size(); ++i) {
      const double straight = distance(fan.soup.positions[i], fan.soup.positions[source]);
      if (!(straight > 0)) continue;
      const std::uint32_t v = surface.vertex(i);
      worst = std::max(worst, std::abs(exact.distance[v] / straight - 1));
      beyond = std::max(beyond, within.distance[v] / straight - 1);
      below = std::max(below, 1 - upper.distance[v] / straight);
    }
    CHECK(worst < 1e-9);
    CHECK(beyond < 1e-4 * (1 + 1e-9));
    CHECK(below < 1e-12);
  }
}

TEST_CASE("BothExactMethodsAgreeOnEllipticCylinders") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 25; ++round) {
    const Surface surface(elliptic_cylinder(random));
    const auto source = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
    const std::vector<Source> from{{point_at_vertex(surface.adjacency(), source), 0}};
    const Field exact = surface.field_by(Method::exact, from);
    const Field other = surface.field_by(Method::chen_han, from);
    double worst = 0;
    for (std::size_t v = 0; v < exact.distance.size(); ++v) {
      const double least = std::min(exact.distance[v], other.distance[v]);
      if (least > 0)
        worst = std::max(worst, std::abs(exact.distance[v] - other.distance[v]) / least);
    }
    CAPTURE(round);
    CHECK(worst < 1e-9);
  }
}
