#include "tests/bench/subjects.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <utility>

#include "proto/formats/decode_mesh.h"
#include "tests/bench/prepared.h"
#include "tests/fixtures/among_squares.h"
#include "tests/fixtures/tube.h"
#include "tests/paper/real_meshes.h"

namespace geodesic::bench {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::infinity();

}  // namespace

TriangleSoup cylinder(std::uint32_t around, std::uint32_t along, double length) {
  return fixtures::tube(around, length, along - 1);
}

TriangleSoup stretched(TriangleSoup soup, double factor) {
  for (Vec3& p : soup.positions) p.x *= factor;
  return soup;
}

Holes holes_of_the_paper(Scale scale) {
  if (scale == Scale::small) {
    return {20, {{8, 8, 4}}, {{6, 7, 6}, {15, 13, 2}}, {{6, 7, 6}, {15, 13, 2}, {9, 2, 6}}};
  }
  return {100,
          {{40, 40, 20}},
          {{30, 36, 30}, {74, 64, 12}},
          {{30, 36, 30}, {74, 64, 12}, {45, 10, 28}}};
}

Subject plane_among_holes(std::string name, std::string title, std::uint32_t side,
                          const std::vector<shapes::Hole>& holes, shapes::Diagonal diagonal) {
  Subject subject{std::move(name),
                  std::move(title),
                  shapes::plane_with_holes(side, side, holes, diagonal),
                  {},
                  "closed form"};
  std::vector<fixtures::Square> squares;
  for (const shapes::Hole& hole : holes) {
    const double x = hole.first_column;
    const double y = hole.first_row;
    squares.push_back({x, y, x + hole.size, y + hole.size});
  }
  const auto& positions = subject.soup.positions;
  subject.known.assign(positions.size(), kNotKnown);
  // A vertex inside a hole has no face, and no distance.
  for (const auto& face : subject.soup.faces) {
    for (const std::uint32_t v : face) subject.known[v] = 0;
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (subject.known[v] != 0) continue;
    subject.known[v] = fixtures::shortest_among(squares, {positions[0].x, positions[0].y},
                                                {positions[v].x, positions[v].y});
  }
  return subject;
}

std::vector<Subject> formula_subjects(Scale scale) {
  const bool full = scale == Scale::full;
  const auto pick = [full](std::uint32_t large, std::uint32_t small) {
    return full ? large : small;
  };
  const auto squared = [](const char* what, std::uint32_t side) {
    return std::string(what) + ", " + std::to_string(side) + " x " + std::to_string(side);
  };
  const Holes holes = holes_of_the_paper(scale);
  const std::uint32_t plane = holes.side;
  const std::uint32_t levels = pick(6, 2);
  const std::uint32_t saddle = pick(120, 16);
  const std::uint32_t terrain = pick(200, 16);
  const std::uint32_t long_terrain = pick(100, 16);
  std::vector<Subject> subjects;
  subjects.push_back(plane_among_holes("plane", squared("plane", plane), plane, {}));
  subjects.push_back(
      plane_among_holes("plane_three_holes", "plane with three holes", plane, holes.three));
  subjects.push_back({"icosphere",
                      "icosphere, " + std::to_string(levels) + " levels",
                      shapes::icosphere(levels),
                      {},
                      {}});
  subjects.push_back(
      {"torus_knot", "torus knot", shapes::torus_knot(pick(600, 60), pick(32, 8), 0.4), {}, {}});
  subjects.push_back(
      {"saddle", squared("saddle", saddle), shapes::saddle(saddle, saddle / 4.0), {}, {}});
  subjects.push_back({"terrain",
                      squared("terrain", terrain),
                      shapes::terrain(terrain, terrain / 10.0, 1),
                      {},
                      {}});
  subjects.push_back({"stretched_terrain",
                      squared("terrain", long_terrain) + ", stretched 8 times",
                      stretched(shapes::terrain(long_terrain, long_terrain / 10.0, 1), 8),
                      {},
                      {}});
  subjects.push_back(
      {"sliver_cylinder", "cylinder of slivers", cylinder(pick(400, 40), pick(25, 8), 10), {}, {}});
  return subjects;
}

std::optional<Subject> scanned_subject(const std::string& name) {
  auto loaded = fixtures::load_real_mesh(name);
  if (!loaded) {
    std::fprintf(stderr, "skipped: no %s with its reference; set GEODESIC_SHARED\n", name.c_str());
    return {};
  }
  if (!*loaded) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), loaded->error().detail.c_str());
    std::exit(1);
  }
  fixtures::RealMesh& mesh = **loaded;
  for (double& d : mesh.exact) {
    if (!fixtures::has_reference(d)) d = kNotKnown;
  }
  return Subject{name, name, std::move(mesh.soup), std::move(mesh.exact), "public exact code"};
}

std::vector<Subject> scanned_subjects() {
  std::vector<Subject> subjects;
  for (const char* name : fixtures::kRealMeshes) {
    if (auto subject = scanned_subject(name)) subjects.push_back(std::move(*subject));
  }
  return subjects;
}

TriangleSoup soup_of_file(const std::string& file) {
  auto decoded = proto::decode_mesh(fixtures::read_bytes(file), proto::DecodeLimits{});
  if (!decoded) give_up(file + ": " + decoded.error().detail);
  return std::move(decoded->soup);
}

}  // namespace geodesic::bench
