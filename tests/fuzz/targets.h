// What is fuzzed: each target takes any bytes, and throws `Broken` if something is not
// as it must be. libFuzzer runs each as a program of its own (`make fuzz`); fuzz_tests
// runs all of them over their seeds, past findings and some mutations.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace geodesic::fuzz {

using Input = std::span<const std::uint8_t>;

struct Broken : std::logic_error {
  using std::logic_error::logic_error;
};

inline void expect(bool holds, const char* what) {
  if (!holds) throw Broken(what);
}

struct Target {
  std::string_view name;
  void (*run)(Input);
  std::vector<std::string> (*seeds)();
};

// By name: gltf, draco, polygons, mesh, requests, points, frame, methods, heaps, lines, walls,
// costs, measures, head, body, form, proxy_header, forwarded.
[[nodiscard]] std::span<const Target> targets();

void fuzz_decoding(Input input);
void fuzz_mesh(Input input);
void fuzz_requests(Input input);
void fuzz_points(Input input);
void fuzz_frame(Input input);
void fuzz_methods(Input input);
void fuzz_heaps(Input input);
void fuzz_lines(Input input);
void fuzz_walls(Input input);
void fuzz_costs(Input input);
void fuzz_measures(Input input);
void fuzz_head(Input input);
void fuzz_body(Input input);
void fuzz_form(Input input);
void fuzz_proxy_header(Input input);
void fuzz_forwarded(Input input);

// Valid files, made by our own encoder and fixtures.
[[nodiscard]] std::vector<std::string> gltf_seeds();
[[nodiscard]] std::vector<std::string> draco_seeds();
[[nodiscard]] std::vector<std::string> polygon_seeds();  // OBJ, PLY and STL
[[nodiscard]] std::vector<std::string> mesh_seeds();
[[nodiscard]] std::vector<std::string> heap_seeds();
[[nodiscard]] std::vector<std::string> line_seeds();
[[nodiscard]] std::vector<std::string> wall_seeds();
[[nodiscard]] std::vector<std::string> cost_seeds();
[[nodiscard]] std::vector<std::string> request_seeds();
[[nodiscard]] std::vector<std::string> point_seeds();
[[nodiscard]] std::vector<std::string> frame_seeds();
[[nodiscard]] std::vector<std::string> head_seeds();
[[nodiscard]] std::vector<std::string> body_seeds();
[[nodiscard]] std::vector<std::string> form_seeds();
[[nodiscard]] std::vector<std::string> proxy_header_seeds();
[[nodiscard]] std::vector<std::string> forwarded_seeds();

}  // namespace geodesic::fuzz
