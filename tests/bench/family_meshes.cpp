#include "tests/bench/family_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "core/mesh/shapes.h"
#include "tests/bench/outline.h"
#include "tests/bench/subjects.h"

namespace geodesic::bench {
namespace {

// Draws; of mt19937 alone, whose numbers are the same everywhere.
class Draw {
 public:
  Draw(std::uint32_t seed, std::uint32_t number) {
    std::seed_seq both{seed, number};
    random_.seed(both);
  }
  double unit() { return random_() / 4294967296.0; }
  double between(double least, double most) { return least + (most - least) * unit(); }
  // Each power of ten as likely.
  double scale(double least, double most) { return least * std::pow(most / least, unit()); }
  std::uint32_t count(std::uint32_t least, std::uint32_t most) {
    return least + random_() % (most - least + 1);
  }

 private:
  std::mt19937 random_;
};

void shake(TriangleSoup& soup, double by, Draw& draw) {
  for (Vec3& p : soup.positions) {
    p = {p.x + by * (draw.unit() - 0.5), p.y + by * (draw.unit() - 0.5),
         p.z + by * (draw.unit() - 0.5)};
  }
}

void drop_patches(TriangleSoup& soup, Draw& draw) {
  Vec3 low = soup.positions[0];
  Vec3 high = low;
  for (const Vec3& p : soup.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const std::size_t least = soup.faces.size() / 2;
  const std::uint32_t patches = draw.count(1, 12);
  for (std::uint32_t i = 0; i < patches; ++i) {
    const Vec3 centre =
        soup.positions[draw.count(0, static_cast<std::uint32_t>(soup.positions.size()) - 1)];
    const double radius = draw.between(0.02, 0.12) * norm(high - low);
    auto faces = soup.faces;
    std::erase_if(faces, [&](const auto& face) {
      return distance(soup.positions[face[0]], centre) < radius;
    });
    // Of a needle a patch may be nearly all.
    if (faces.size() >= least) soup.faces = std::move(faces);
  }
}

// Edges become up to `most` times as long towards one side, in both directions of a plane.
void grade(TriangleSoup& soup, double side, double most) {
  const double rate = std::log(most) / side;
  for (Vec3& p : soup.positions) {
    p = {std::expm1(rate * p.x) / rate, std::expm1(rate * p.y) / rate, p.z};
  }
}

TriangleSoup fan_of_slivers(Draw& draw, double height) {
  const std::uint32_t tips = draw.count(200, 4000);
  const std::uint32_t rows = draw.count(1, 4);
  std::vector<ProfilePoint> profile{{0, height}};
  for (std::uint32_t r = 1; r <= rows; ++r) {
    profile.push_back(
        {static_cast<double>(r) / rows, height * (1 - static_cast<double>(r) / rows)});
  }
  return turned(profile, tips);
}

// A plane whose rows of triangles are as flat as caps are: the middle vertex close to the base.
TriangleSoup caps(Draw& draw) {
  const std::uint32_t side = draw.count(30, 70);
  TriangleSoup soup = shapes::plane(side, side);
  const double thin = draw.scale(1e-4, 0.3);
  for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
    Vec3& p = soup.positions[v];
    const std::uint32_t row = v / side;
    p = {p.x + (row % 2 == 0 ? 0.0 : 0.5), p.y * thin, 0.02 * thin * draw.unit()};
  }
  return soup;
}

Outline gear(Draw& draw) {
  const std::uint32_t teeth = draw.count(8, 60);
  const std::uint32_t points = draw.count(2, 20);  // along a flank
  const double depth = draw.between(0.08, 0.3);
  Outline outline;
  for (std::uint32_t t = 0; t < teeth; ++t) {
    for (std::uint32_t i = 0; i < 4 * points; ++i) {
      const double part = static_cast<double>(i) / (4 * points);
      const double shape = std::clamp(2 * std::sin(2 * std::numbers::pi * part), -1.0, 1.0);
      const double angle = 2 * std::numbers::pi * (t + part) / teeth;
      const double radius = 1 + depth / 2 * shape;
      outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
  }
  return outline;
}

// Circles of holes that keep clear of each other, in the square from -1 to 1.
std::vector<Outline> drilled(Draw& draw, std::uint32_t rows, double radius, std::uint32_t points) {
  std::vector<Outline> holes;
  for (std::uint32_t i = 0; i < rows; ++i) {
    for (std::uint32_t j = 0; j < rows; ++j) {
      const double pitch = 2.0 / (rows + 1);
      const double r = pitch * radius * draw.between(0.6, 1);
      const OutlinePoint at{-1 + pitch * (i + 1 + 0.1 * draw.unit()),
                            -1 + pitch * (j + 1 + 0.1 * draw.unit())};
      holes.push_back(circle(at, r, points, true));
    }
  }
  return holes;
}

Outline rounded_square(double corner, std::uint32_t points) {
  Outline outline;
  for (std::uint32_t q = 0; q < 4; ++q) {
    const double sx = q == 0 || q == 3 ? 1 : -1;
    const double sy = q < 2 ? 1 : -1;
    for (std::uint32_t i = 0; i <= points; ++i) {
      const double angle = std::numbers::pi / 2 * (q + static_cast<double>(i) / points);
      outline.push_back({sx * (1 - corner) + corner * std::cos(angle),
                         sy * (1 - corner) + corner * std::sin(angle)});
    }
  }
  return outline;
}

}  // namespace

FamilyMesh surface_of_family(std::uint32_t seed, std::uint32_t number) {
  Draw draw(seed, number);
  FamilyMesh mesh;
  TriangleSoup& soup = mesh.soup;
  switch (number % kSurfaceKinds) {
    case 0:
      mesh.kind = "terrain";
      soup = shapes::terrain(draw.count(30, 90), draw.between(0, 30), seed + number);
      break;
    case 1:
      mesh.kind = "rough ball";
      soup = shapes::icosphere(4);
      shake(soup, draw.between(0, 0.06), draw);
      break;
    case 2:
      mesh.kind = "stretched terrain";
      soup = stretched(shapes::terrain(draw.count(30, 80), draw.between(0, 20), seed + number),
                       draw.scale(1, 1000));
      break;
    case 3:
      mesh.kind = "stretched ball";
      soup = shapes::icosphere(4);
      shake(soup, draw.between(0, 0.03), draw);
      soup = stretched(std::move(soup), draw.scale(1, 1000));
      break;
    case 4:
      mesh.kind = "cylinder of slivers";
      soup = cylinder(draw.count(200, 2000), draw.count(3, 12), draw.between(1, 20));
      break;
    case 5:
      mesh.kind = "cone of slivers";
      soup = fan_of_slivers(draw, draw.scale(0.1, 10));
      break;
    case 6:
      mesh.kind = "flat fan";
      soup = fan_of_slivers(draw, 0);
      break;
    case 7: {
      mesh.kind = "needles";
      const double thin = draw.scale(1e-3, 0.3);
      soup = shapes::plane(draw.count(30, 70), draw.count(30, 70));
      shake(soup, 0.4, draw);
      for (Vec3& p : soup.positions) p.x *= thin;
      break;
    }
    case 8:
      mesh.kind = "caps";
      soup = caps(draw);
      break;
    case 9: {
      mesh.kind = "edges of all lengths";
      const std::uint32_t side = draw.count(40, 80);
      soup = shapes::plane(side, side);
      shake(soup, draw.between(0, 0.4), draw);
      grade(soup, side, draw.scale(10, 1e4));
      break;
    }
    case 10:
      mesh.kind = "folds";
      soup = shapes::saddle(draw.count(30, 70), draw.between(5, 60));
      shake(soup, draw.between(0, 0.4), draw);
      break;
    default:
      mesh.kind = "knot";
      soup = shapes::torus_knot(draw.count(100, 500), draw.count(5, 16), draw.between(0.1, 0.4));
      break;
  }
  if (draw.unit() < 0.3) {
    mesh.kind += " with holes";
    drop_patches(soup, draw);
  }
  return mesh;
}

FamilyMesh part_of_family(std::uint32_t seed, std::uint32_t number) {
  Draw draw(seed, number);
  const std::uint32_t around = draw.count(64, 1500);
  const std::uint32_t rings = draw.count(1, 3);
  const double height = draw.scale(0.1, 3);
  switch (number % kPartKinds) {
    case 0:
      return {"prism with fans",
              turned({{0, 0}, {1, 0}, {1, height / 2}, {1, height}, {0, height}}, 2 * around)};
    case 1:
      return {"gear",
              extrusion(gear(draw), {circle({0, 0}, 0.3, around / 8 + 3, true)}, height, rings)};
    case 2:
      return {"plate with drilled holes",
              extrusion({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}},
                        drilled(draw, draw.count(1, 6), 0.35, draw.count(12, 80)), 0.2 * height,
                        rings)};
    case 3: {
      std::vector<ProfilePoint> profile{{0, 0}};
      double z = 0;
      const std::uint32_t steps = draw.count(2, 8);
      for (std::uint32_t i = 0; i < steps; ++i) {
        const double radius = draw.between(0.2, 1);
        profile.push_back({radius, z});
        z += draw.between(0.1, 1);
        profile.push_back({radius, z});
      }
      profile.push_back({0, z});
      return {"turned part", turned(profile, around)};
    }
    case 4:
      return {"extruded angle", extrusion({{0, 0}, {2, 0}, {2, 0.3}, {0.3, 0.3}, {0.3, 2}, {0, 2}},
                                          {}, height, draw.count(50, 800))};
    case 5: {
      TriangleSoup solid = turned({{0, 0}, {1, 0}, {1, height}, {0, height}}, around);
      const double lean = draw.between(0, 0.8);
      return {"cylinder cut off", cut_off(solid, {std::sin(lean), 0, std::cos(lean)},
                                          {0, 0, height * draw.between(0.3, 0.7)})};
    }
    case 6: {
      const double inner = draw.between(0.3, 0.95);
      return {"tube",
              extrusion(circle({0, 0}, 1, around),
                        {circle({0, 0}, inner, draw.count(32, 800), true)}, 3 * height, rings)};
    }
    case 7: {
      std::vector<Outline> holes{circle({0, 0}, 0.4, around / 4 + 8, true)};
      const std::uint32_t bolts = draw.count(3, 12);
      for (std::uint32_t i = 0; i < bolts; ++i) {
        const double angle = 2 * std::numbers::pi * i / bolts;
        holes.push_back(
            circle({0.7 * std::cos(angle), 0.7 * std::sin(angle)}, 0.08, draw.count(12, 60), true));
      }
      return {"flange", extrusion(circle({0, 0}, 1, around), holes, 0.3 * height, rings)};
    }
    case 8:
      return {"rounded box",
              extrusion(rounded_square(draw.scale(0.01, 0.9), around / 4 + 4), {}, height, rings)};
    case 9:
      return {"frustum",
              turned({{0, 0}, {1, 0}, {draw.between(0.05, 0.9), height}, {0, height}}, 2 * around)};
    case 10: {
      // A block cut thrice: each cut crosses the slivers of the one before.
      TriangleSoup solid = extrusion(circle({0, 0}, 1, around), {}, height, draw.count(2, 6));
      for (int i = 0; i < 3; ++i) {
        const double angle = 2 * std::numbers::pi * draw.unit();
        const double reach = draw.between(0.4, 0.8);
        const Vec3 normal{std::cos(angle), std::sin(angle), draw.between(-0.2, 0.2)};
        solid = cut_off(solid, normal,
                        {reach * normal.x, reach * normal.y, height / 2 + reach * normal.z});
      }
      return {"cylinder cut thrice", std::move(solid)};
    }
    default: {
      Outline star;
      const std::uint32_t tips = draw.count(5, 40);
      const std::uint32_t between = draw.count(1, 30);
      const double inner = draw.between(0.3, 0.9);
      for (std::uint32_t t = 0; t < 2 * tips; ++t) {
        const auto at = [&](std::uint32_t tip) {
          const double angle = std::numbers::pi * tip / tips;
          const double radius = tip % 2 == 0 ? 1 : inner;
          return OutlinePoint{radius * std::cos(angle), radius * std::sin(angle)};
        };
        for (std::uint32_t i = 0; i < between; ++i) {
          const double part = static_cast<double>(i) / between;
          const OutlinePoint a = at(t);
          const OutlinePoint b = at(t + 1);
          star.push_back({a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)});
        }
      }
      return {"splined shaft", extrusion(star, {}, height, rings)};
    }
  }
}

}  // namespace geodesic::bench
