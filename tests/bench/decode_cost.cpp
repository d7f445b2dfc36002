// decode_bench: what it costs to have a mesh file of a million vertices ready for
// questions, beside the plain library that reads its format and a textbook Dijkstra.
// Exit status 1 if it is more than twice the library plus six yardsticks.
#include <draco/compression/decode.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_USE_CPP14
#include <tiny_gltf.h>

#include "core/mesh/shapes.h"
#include "core/surface/adjacency.h"
#include "proto/encode/encode_mesh.h"
#include "proto/formats/decode_mesh.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/processor_time.h"

using namespace geodesic;

namespace {

constexpr int kRounds = 5;

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "decode_bench: %s\n", why.c_str());
  std::exit(2);
}

// What whoever uses the libraries alone gets: the binary in a buffer, views of it described.
void decode_plainly_glb(std::span<const std::byte> file) {
  tinygltf::Model model;
  std::string error;
  std::string warning;
  if (!tinygltf::TinyGLTF().LoadBinaryFromMemory(
          &model, &error, &warning, reinterpret_cast<const unsigned char*>(file.data()),
          static_cast<unsigned int>(file.size()))) {
    give_up(error);
  }
}

void decode_plainly_drc(std::span<const std::byte> file) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(file.data()), file.size());
  draco::Decoder decoder;
  const auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok()) give_up(mesh.status().error_msg_string());
}

Adjacency prepared(std::span<const std::byte> file) {
  auto decoded = proto::decode_mesh(file, {});
  if (!decoded) give_up(decoded.error().detail);
  auto mesh = Mesh::build(decoded->soup);
  if (!mesh) give_up(mesh.error().detail);
  decoded->soup = {};
  return Adjacency::build(std::make_shared<const Mesh>(std::move(*mesh)));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool print_cost(const char* name, std::span<const std::byte> file,
                void (*decode_plainly)(std::span<const std::byte>)) {
  std::vector<double> plain;
  std::vector<double> ours;
  std::vector<double> yardstick;
  for (int round = 0; round < kRounds; ++round) {
    plain.push_back(bench::processor_ms_of([&] { decode_plainly(file); }));
    std::unique_ptr<Adjacency> adjacency;
    ours.push_back(
        bench::processor_ms_of([&] { adjacency = std::make_unique<Adjacency>(prepared(file)); }));
    bench::Yardstick dijkstra(*adjacency);
    (void)dijkstra.ms(0);  // takes its memory
    yardstick.push_back(dijkstra.ms(0));
  }
  const double bound = 2 * median(plain) + 6 * median(yardstick);
  const bool is_kept = median(ours) <= bound;
  std::printf("| %s | %zu | %.0f | %.0f | %.0f | %.0f | %.2f | %s |\n", name, file.size(),
              median(plain), median(yardstick), median(ours), bound, median(ours) / bound,
              is_kept ? "yes" : "**no**");
  std::fflush(stdout);
  return is_kept;
}

}  // namespace

int main() {
  const TriangleSoup terrain = shapes::terrain(1000, 20, 1);
  std::puts(
      "| file of a million vertices | bytes | library ms | y ms | ours ms | 2 library + 6 y | "
      "ours over it | kept |\n|---|--:|--:|--:|--:|--:|--:|---|");
  const auto drc = proto::encode_drc(terrain, 14);
  if (!drc) give_up(drc.error().detail);
  const bool glb_kept =
      print_cost("GLB", proto::encode_glb(terrain, "terrain"), decode_plainly_glb);
  const bool drc_kept = print_cost("Draco", *drc, decode_plainly_drc);
  std::puts(
      "\nProcessor time, medians of five rounds; ours: decode, weld, order, connect, Delaunay.");
  return glb_kept && drc_kept ? 0 : 1;
}
