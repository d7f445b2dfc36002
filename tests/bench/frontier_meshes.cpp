#include "tests/bench/frontier_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <random>
#include <utility>

#include "core/mesh/shapes.h"
#include "tests/bench/family_meshes.h"
#include "tests/bench/irregular_plane.h"
#include "tests/bench/subjects.h"

namespace geodesic::bench {
namespace {

constexpr double kNoAim = std::numeric_limits<double>::infinity();
constexpr Aim kScan{1e-4, 1e-3, 3e-3, 1.5, 6, 15};
// For `exact`, half of what a sphere of 655,362 vertices took in 2026-11.
constexpr Aim kSphere{1e-4, 1e-3, 3e-3, 1.5, 6, 110};
// As on any surface of a family (family.h).
constexpr Aim kAwkward{5e-4, kNoAim, 1e-2, 4, 6, 60};
// For `exact`, 0.6 and 0.4 of what a million vertices took then.
constexpr Aim kBumpy{1e-4, 1e-3, 3e-3, 1.5, 6, 37};
constexpr Aim kSmooth{1e-4, 1e-3, 3e-3, 1.5, 6, 122};

// As steep whatever its size; the paper's wavefront is 0.7 % off on a million vertices.
TriangleSoup bumpy_plane(std::uint32_t count) {
  return irregular_plane(count, 0.132 * std::sqrt(count), 1);
}

double unit(std::mt19937& random) { return random() / 4294967296.0; }

Vec3 direction(std::mt19937& random) {
  for (;;) {
    const Vec3 d{2 * unit(random) - 1, 2 * unit(random) - 1, 2 * unit(random) - 1};
    const double length = norm(d);
    if (length > 0.1 && length < 1) return 1 / length * d;
  }
}

// Waves of all lengths upon a ball, the shorter the lower, and vertices in no pattern.
TriangleSoup bumpy_ball(std::mt19937& random) {
  constexpr std::uint32_t kLevels = 5;
  constexpr double kEdge = 0.035;  // about as long as its edges are
  struct Wave {
    Vec3 along;
    double rate;
    double phase;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 30; ++i) {
    waves.push_back({direction(random), 2 * std::pow(12.0, unit(random)), 7 * unit(random)});
  }
  TriangleSoup soup = shapes::icosphere(kLevels);
  for (Vec3& p : soup.positions) {
    p = p + 0.3 * kEdge * direction(random);
    double height = 1;
    for (const Wave& wave : waves) {
      height += 0.1 / wave.rate * std::sin(wave.rate * dot(wave.along, p) + wave.phase);
    }
    p = height * p;
  }
  return soup;
}

}  // namespace

std::vector<FrontierMesh> drawn_meshes(std::uint32_t seed) {
  constexpr std::uint32_t kSide = 100;
  // Of a part with thin faces, each field is by `exact`: some thousand vertices take minutes.
  constexpr std::size_t kLeastVertices = 500;
  constexpr std::size_t kMostVertices = 1500;
  std::mt19937 random(seed);
  std::vector<FrontierMesh> meshes;
  meshes.push_back({"bumpy ball", bumpy_ball(random), kScan});
  const double height = 5 + 20 * unit(random);
  meshes.push_back(
      {"terrain", shapes::terrain(kSide, height, static_cast<std::uint32_t>(random())), kScan});
  FamilyMesh part;
  do {
    part = part_of_family(seed, static_cast<std::uint32_t>(random() % 1000));
  } while (part.soup.positions.size() < kLeastVertices ||
           part.soup.positions.size() > kMostVertices);
  meshes.push_back({part.kind, std::move(part.soup), kAwkward});
  for (FrontierMesh& mesh : meshes) {
    mesh.title += " of " + std::to_string(mesh.soup.positions.size());
    mesh.first_source = mesh.soup.faces[random() % mesh.soup.faces.size()][0];
  }
  return meshes;
}

std::vector<FrontierMesh> frontier_meshes(bool quick) {
  std::vector<FrontierMesh> meshes;
  for (Subject& scan : scanned_subjects()) {
    FrontierMesh stretch{scan.title + ", stretched", stretched(scan.soup, 8), kAwkward};
    meshes.push_back({scan.title, std::move(scan.soup), kScan, true});
    meshes.push_back(std::move(stretch));
  }
  meshes.push_back({"icosphere of 163,842", shapes::icosphere(7), kSphere});
  meshes.push_back({"bumpy plane of 90,000", bumpy_plane(90'000), kBumpy});
  meshes.push_back({"terrain of 90,000", shapes::terrain(300, 20, 1), kScan});
  // 0.003 by 0.5: 160 times as long as wide.
  meshes.push_back({"cylinder of slivers", cylinder(2000, 20, 10), kAwkward});
  const Holes holes = holes_of_the_paper(Scale::full);
  meshes.push_back(
      {"plane with holes", shapes::plane_with_holes(holes.side, holes.side, holes.three), kScan});
  if (quick) return meshes;
  meshes.push_back({"icosphere of 655,362", shapes::icosphere(8), kSphere, false, true});
  FrontierMesh million{"bumpy plane of 1,000,000", bumpy_plane(1'000'000), kBumpy, false, true};
  FrontierMesh other{
      "the same, shuffled", shapes::shuffled(million.soup, 1), kBumpy, false, true, true};
  // From the same place, or times would differ by that.
  const auto& shuffled = other.soup.positions;
  other.first_source = static_cast<std::uint32_t>(
      std::find(shuffled.begin(), shuffled.end(), million.soup.positions[0]) - shuffled.begin());
  meshes.push_back(std::move(million));
  meshes.push_back(std::move(other));
  // Smoother: a line from the source meets few bends, and an edge has more windows.
  meshes.push_back({"terrain of 1,000,000", shapes::terrain(1000, 20, 1), kSmooth, false, true});
  return meshes;
}

std::vector<FrontierMesh> meshes_of(const std::vector<std::string>& files) {
  std::vector<FrontierMesh> meshes;
  for (const std::string& file : files) {
    TriangleSoup soup = soup_of_file(file);
    const bool large = soup.positions.size() >= 500'000;
    meshes.push_back({std::filesystem::path(file).filename(), std::move(soup), kScan, true, large});
  }
  return meshes;
}

}  // namespace geodesic::bench
