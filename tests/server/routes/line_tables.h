// Tables whose rows or columns are lines, at random.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/server/routes/plane_service.h"
#include "tests/server/routes/streamed_table.h"

namespace geodesic::server::test {

using fixtures::RandomMesh;

struct LineTables : PlaneService {
  using PlaneService::PlaneService;

  HttpResponse table(const std::string& at, const json& asked) {
    return service.ask("POST", at + "/table", asked.dump());
  }
  std::vector<double> streamed(const std::string& at, json asked) {
    asked["stream"] = true;
    asked["format"] = "f64";
    return numbers_in<double>(whole_stream(table(at, asked)));
  }
};

// Calls `attempt(random, base)` with as many random meshes, each uploaded; under a sanitizer with a
// quarter.
template <class Attempt>
void with_random_meshes(LineTables& plane, std::uint32_t seed, int count, Attempt attempt) {
  std::mt19937 seeds(seed);
  for (int round = 0; round < fixtures::all_or(count, (count + 3) / 4); ++round) {
    const auto number = static_cast<std::uint32_t>(seeds());
    CAPTURE(number);
    RandomMesh random(number);
    attempt(random, plane.add(random.soup()));
  }
}

inline std::string some_vertex(RandomMesh& mesh) { return "v:" + std::to_string(mesh.vertex()); }
inline std::string in_some_face(RandomMesh& mesh) {
  const double first = 0.05 + 0.4 * mesh.unit();
  return "f:" + std::to_string(mesh.below(mesh.face_count())) + "," + std::to_string(first) + "," +
         std::to_string(0.05 + 0.4 * mesh.unit());
}
inline std::string some_place(RandomMesh& mesh) {
  return mesh.unit() < 0.5 ? some_vertex(mesh) : in_some_face(mesh);
}

// A curve may be between two pieces, and a surface without a boundary.
inline std::string some_row(RandomMesh& mesh) {
  switch (mesh.below(5)) {
    case 0:
      return some_place(mesh);
    case 1:
      return mesh.unit() < 0.5 ? "boundary" : "boundary:0";
    case 2: {
      const std::uint32_t first = mesh.below(mesh.face_count());
      const std::uint32_t last = first + mesh.below(mesh.face_count() - first);
      return "faces:" + std::to_string(first) + "-" + std::to_string(std::min(last, first + 9));
    }
    case 3:
      return "curve:closed;" + some_place(mesh) + ";" + some_place(mesh) + ";" + some_place(mesh);
    default:
      return "curve:" + some_place(mesh) + ";" + some_place(mesh);
  }
}

inline json some_method(RandomMesh& mesh) {
  switch (mesh.below(7)) {
    case 0:
      return {{"method", "chen_han"}};
    case 1:
      return {{"method", "dijkstra"}};
    case 2:
      return {{"method", "steiner"}, {"points_per_edge", 2}};
    case 3:
      return {{"method", "fast_marching"}};
    case 4:
      return {{"bound", "upper"}};
    case 5:
      return json::object();
    default:
      return {{"method", "exact"}};
  }
}

}  // namespace geodesic::server::test
