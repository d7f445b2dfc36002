// The decoder against public files: valid ones must agree with an independent
// reader's figures, bad and hostile ones must end soon in an error or a valid
// mesh. The files are optional; where they are is said in shared_corpora().
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "proto/formats/decode_mesh.h"

using namespace geodesic;
using namespace geodesic::proto;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

// The environment's GEODESIC_SHARED, else the build's; nothing, with a message,
// when there are no corpora there.
std::optional<fs::path> shared_corpora() {
  const char* from_environment = std::getenv("GEODESIC_SHARED");
  const fs::path shared = from_environment != nullptr ? from_environment : GEODESIC_SHARED;
  if (fs::is_directory(shared / "corpora")) return shared / "corpora";
  MESSAGE("skipped: no folder of corpora; set GEODESIC_SHARED");
  return std::nullopt;
}

std::vector<std::byte> read_bytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

json read_json(const fs::path& path) {
  std::ifstream in(path);
  return json::parse(in);
}

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

double area_of(const TriangleSoup& soup) {
  double area = 0;
  for (const auto& [a, b, c] : soup.faces) {
    area +=
        norm(cross(soup.positions[b] - soup.positions[a], soup.positions[c] - soup.positions[a])) /
        2;
  }
  return area;
}

// What `Mesh::build` may rely on.
void check_is_valid(const DecodedMesh& mesh) {
  REQUIRE_FALSE(mesh.soup.faces.empty());
  const auto count = mesh.soup.positions.size();
  CHECK(std::ranges::all_of(mesh.soup.positions, [](const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  }));
  CHECK(std::ranges::all_of(mesh.soup.faces, [count](const auto& face) {
    return face[0] < count && face[1] < count && face[2] < count;
  }));
  std::uint64_t faces = 0;
  for (const MeshPart& part : mesh.parts) {
    CHECK(part.first_face == faces);
    CHECK(part.first_vertex + part.vertex_count <= count);
    faces += part.face_count;
  }
  CHECK(faces == mesh.soup.faces.size());
}

// Whether a message says where in the file the fault is.
bool names_a_place(const std::string& detail) {
  static constexpr std::string_view places[] = {"accessor", "buffer",  "node",      "mesh ",
                                                "scene",    "chunk",   "extension", "JSON",
                                                "GLB",      "version", "The bytes"};
  return std::ranges::any_of(
      places, [&](std::string_view place) { return detail.find(place) != std::string::npos; });
}

bool is_about_bounds_alone(const json& errors) {
  return std::ranges::all_of(errors, [](const json& error) {
    const auto& text = error.get_ref<const std::string&>();
    return text.starts_with("ACCESSOR_MIN_MISMATCH") || text.starts_with("ACCESSOR_MAX_MISMATCH");
  });
}

// Faces, where of parts with the same node, mesh and primitive one counts.
std::size_t faces_of_first_instances(const DecodedMesh& mesh) {
  std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> seen;
  std::size_t faces = 0;
  for (const MeshPart& part : mesh.parts) {
    if (seen.emplace(part.node, part.mesh, part.primitive).second) faces += part.face_count;
  }
  return faces;
}

}  // namespace

TEST_CASE("valid glTF files agree with the oracle in triangles, area and bounding box") {
  const auto corpora = shared_corpora();
  if (!corpora) return;
  const json oracle = read_json(*corpora / "gltf-good.json");
  int agreed = 0;
  int instancing = 0;
  for (const auto& path : files_below(*corpora / "gltf-good")) {
    const std::string key = fs::relative(path, *corpora).string();
    CAPTURE(key);
    const auto mesh = decode_mesh(read_bytes(path), DecodeLimits{});
    if (key.find("/no-triangles/") != std::string::npos) {
      REQUIRE_FALSE(mesh.has_value());
      CHECK(mesh.error().code.name() == "no_triangles");
      continue;
    }
    if (!mesh) {
      CAPTURE(mesh.error().detail);
      // The independent reader fails on a file without the data of its buffer.
      const bool oracle_failed = oracle.contains(key) && oracle[key].contains("error");
      if (oracle_failed && mesh.error().code == ErrorCode::mesh_invalid) {
        CHECK(mesh.error().detail.find("has no data") != std::string::npos);
        continue;
      }
      FAIL_CHECK("refused");
      continue;
    }
    check_is_valid(*mesh);
    if (!oracle.contains(key) || oracle[key].contains("error")) continue;
    const json& expected = oracle[key];
    if (expected["gpuInstancingNodes"] != 0) {
      // The oracle draws instances once: what is there more than once is compared
      // by the number of its faces.
      ++instancing;
      CHECK(faces_of_first_instances(*mesh) == expected["triangles"].get<std::size_t>());
      CHECK(mesh->soup.faces.size() >= expected["triangles"].get<std::size_t>());
      continue;
    }
    CHECK(mesh->soup.faces.size() == expected["triangles"].get<std::size_t>());
    CHECK(area_of(mesh->soup) == doctest::Approx(expected["area"].get<double>()).epsilon(1e-5));
    constexpr double inf = std::numeric_limits<double>::infinity();
    Vec3 low{inf, inf, inf};
    Vec3 high{-inf, -inf, -inf};
    for (const Vec3& p : mesh->soup.positions) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const double tolerance = 1e-5 * norm(high - low);
    const auto vec3 = [](const json& v) { return Vec3{v[0], v[1], v[2]}; };
    CHECK(distance(low, vec3(expected["min"])) <= tolerance);
    CHECK(distance(high, vec3(expected["max"])) <= tolerance);
    ++agreed;
  }
  CHECK(agreed > 0);
  MESSAGE(agreed << " glTF files agree, and " << instancing << " with GPU instances");
}

TEST_CASE("valid Draco files agree with the oracle in points and faces") {
  const auto corpora = shared_corpora();
  if (!corpora) return;
  int meshes = 0;
  int clouds = 0;
  for (const json& expected : read_json(*corpora / "drc-good.json")) {
    const auto file = expected["file"].get<std::string>();
    CAPTURE(file);
    const auto mesh = decode_mesh(read_bytes(*corpora / file), DecodeLimits{});
    if (expected["faces"] == 0) {
      ++clouds;
      REQUIRE_FALSE(mesh.has_value());
      CHECK(mesh.error().code.name() == "no_triangles");
      continue;
    }
    ++meshes;
    if (!mesh) FAIL_CHECK(mesh.error().detail);
    if (!mesh) continue;
    check_is_valid(*mesh);
    CHECK(mesh->soup.positions.size() == expected["points"].get<std::size_t>());
    CHECK(mesh->soup.faces.size() == expected["faces"].get<std::size_t>());
  }
  CHECK(meshes > 0);
  MESSAGE(meshes << " Draco meshes agree, " << clouds << " point clouds refused");
}

TEST_CASE("bad and hostile files end soon, in an error or a valid mesh") {
  const auto corpora = shared_corpora();
  if (!corpora) return;
  using clock = std::chrono::steady_clock;
  std::map<std::string, int> outcomes;
  double slowest = 0;
  const json faults = read_json(*corpora / "bad.json");
  for (const auto& path : files_below(*corpora / "bad")) {
    const std::string key = fs::relative(path, *corpora).string();
    CAPTURE(key);
    const auto bytes = read_bytes(path);
    const auto start = clock::now();
    const auto mesh = decode_mesh(bytes, DecodeLimits{});
    const double seconds = std::chrono::duration<double>(clock::now() - start).count();
    CHECK(seconds < 5);
    slowest = std::max(slowest, seconds);
    if (std::getenv("GEODESIC_VERBOSE") != nullptr) {
      MESSAGE(key << ": "
                  << (mesh ? "accepted"
                           : std::string(mesh.error().code.name()) + ": " + mesh.error().detail));
    }
    if (faults.contains(key) && faults[key]["geometry_related"].get<bool>()) {
      CAPTURE(faults[key]["errors"].dump());
      // Bounds that are not those of the positions are common and change nothing: said,
      // but no reason to refuse.
      CHECK(mesh.has_value() == is_about_bounds_alone(faults[key]["errors"]));
      if (!mesh) CHECK(names_a_place(mesh.error().detail));
    }
    if (mesh) {
      check_is_valid(*mesh);
      ++outcomes["accepted"];
    } else {
      CHECK(mesh.error().code != ErrorCode::internal);
      CHECK_FALSE(mesh.error().detail.empty());
      ++outcomes[std::string(mesh.error().code.name())];
    }
  }
  CHECK_FALSE(outcomes.empty());
  for (const auto& [outcome, count] : outcomes) MESSAGE(count << " bad files: " << outcome);
  MESSAGE("the slowest bad file took " << slowest << " s");
}
