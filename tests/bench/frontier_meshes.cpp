#include "tests/bench/frontier_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/mesh/shapes.h"
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

}  // namespace

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
