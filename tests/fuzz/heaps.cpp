// Every method on heaps of up to 200 faces along a line, in a plane or on few points, where windows
// and fronts have most reason to run away: each query ends soon and takes little memory.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/solve/solve_field.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {
namespace {

#ifdef GEODESIC_SANITIZED
constexpr double kMostSeconds = 20;  // sanitizers take ten times as long
#else
constexpr double kMostSeconds = 2;  // of processor time
#endif
constexpr std::uint64_t kMostBytes = 200'000'000;  // asked for, all in all
constexpr std::uint32_t kMostFaces = 200;

// The input's bytes, and after the last one what a generator seeded by all of them says: so a few
// bytes are a mesh of any size.
class Draws {
 public:
  explicit Draws(Input input) : input_(input) {
    std::seed_seq seed(input.begin(), input.end());
    random_.seed(seed);
  }
  std::uint32_t below(std::uint32_t count) { return (byte() * 256U + byte()) % count; }
  double real() { return (byte() * 256U + byte()) / 65536.0; }

 private:
  std::uint32_t byte() {
    return at_ < input_.size() ? input_[at_++] : static_cast<std::uint32_t>(random_() & 255U);
  }
  Input input_;
  std::size_t at_ = 0;
  std::mt19937 random_;
};

// Thinner by up to 11 orders of magnitude along one axis or two; faces of any three vertices, or
// all about the same edge or corner, each perhaps twice.
TriangleSoup heap(Draws& draws) {
  TriangleSoup soup;
  const double thin = std::pow(10.0, -static_cast<double>(draws.below(12)));
  const double flat = draws.below(3) == 0 ? 0 : draws.below(2) == 0 ? thin : 1;
  const bool is_on_lattice = draws.below(4) == 0;
  const std::uint32_t shared = draws.below(8);  // two corners, one, or none
  const std::uint32_t vertices = 4 + draws.below(60);
  const std::uint32_t faces = 1 + draws.below(kMostFaces);
  const auto place = [&] { return is_on_lattice ? draws.below(8) / 8.0 : draws.real(); };
  for (std::uint32_t i = 0; i < vertices; ++i) {
    soup.positions.push_back({place(), thin * place(), flat * place()});
  }
  for (std::uint32_t i = 0; i < faces; ++i) {
    Triangle face{draws.below(vertices), draws.below(vertices), draws.below(vertices)};
    if (shared <= 1) face[0] = 0;
    if (shared == 0) face[1] = 1;
    soup.faces.push_back(face);
  }
  return soup;
}

struct Query {
  Method method;
  MethodOptions options;
  bool keep_details = true;
};

std::array<Query, 11> queries() {
  MethodOptions upper;
  upper.bound = Bound::upper;
  MethodOptions tolerance;
  tolerance.error_at_most = 1e-3;
  return {{{Method::wavefront, {}},
           {Method::novotni, {}},
           {Method::fast_marching, {}},
           {Method::dijkstra, {}},
           {Method::steiner, {}},
           {Method::exact, {}},
           {Method::exact, {}, false},  // over other faces
           {Method::chen_han, {}},
           {Method::back_traced, {}},
           {Method::back_traced, upper},
           {Method::back_traced, tolerance}}};
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

}  // namespace

void fuzz_heaps(Input input) {
  Draws draws(input);
  auto built = Mesh::build(heap(draws));
  if (!built) return;
  const auto mesh = std::make_shared<const Mesh>(std::move(*built));
  const Adjacency adjacency = Adjacency::build(mesh);
  std::vector<Source> sources{
      {point_at_vertex(adjacency, mesh->faces()[draws.below(kMostFaces) % mesh->face_count()][0]),
       0}};
  if (draws.below(3) == 0) {
    const auto face = draws.below(kMostFaces) % static_cast<std::uint32_t>(mesh->face_count());
    sources.push_back({point_on_face(adjacency, face, {1, 1, 2}), 0.01 * draws.below(100)});
  }
  SolveScratch scratch;
  for (const Query& query : queries()) {
    const double begin = processor_seconds();
    std::uint64_t taken = 0;
    MemoryBudget budget([&taken](std::uint64_t bytes) -> std::optional<Error> {
      taken += bytes;
      if (taken <= kMostBytes) return std::nullopt;
      return Error{ErrorCode::too_large, "too much memory", {}, {}, {}};
    });
    const Cancel cancel([&] { return processor_seconds() - begin > kMostSeconds; }, {}, &budget);
    FieldLimits limits;
    limits.keep_details = query.keep_details;
    const auto field =
        solve_field(query.method, query.options, adjacency, sources, limits, scratch, cancel);
    expect(field || !budget.refusal(), "a query of 200 faces takes 200 MB at most");
    // That is what chen_han says where its windows double with each face.
    const bool is_refused =
        !field && query.method == Method::chen_han && field.error().code == ErrorCode::too_large;
    expect(field || is_refused, "a query of 200 faces takes 2 s at most, or 20 under sanitizers");
  }
}

}  // namespace geodesic::fuzz
