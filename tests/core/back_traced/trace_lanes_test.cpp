#include "core/back_traced/trace_lanes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/back_traced/arrive_lanes.h"
#include "core/mesh/shapes.h"
#include "core/wavefront/virtual_source.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

std::vector<Vectors> vectors_here() {
  std::vector<Vectors> all{Vectors::plain};
  if (best_vectors() == Vectors::avx2) all.push_back(Vectors::avx2);
  if (best_vectors() == Vectors::avx512) {
    all.push_back(Vectors::avx2);
    all.push_back(Vectors::avx512);
  }
  return all;
}

struct Start {
  Halfedge base;
  double crossing;
};

// From every vertex over the side opposite it, as far as the distances go.
std::vector<Start> starts_on(const Triangulation& surface, const std::vector<double>& distance,
                             RandomMesh& random) {
  std::vector<Start> starts;
  for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
    const FaceRecord& face = surface.faces[f];
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (distance[face.vertex[c]] + distance[face.vertex[next_corner(c)]] < kUnreached) {
        starts.push_back({halfedge(f, c), random.unit()});
      }
    }
  }
  return starts;
}

// The same distances as of one source among several: in any of a vertex's slots, beside those of
// other sources, or alone.
class AmongOthers {
 public:
  static constexpr std::uint32_t kNumber = 7;

  AmongOthers(const std::vector<double>& distance, RandomMesh& random)
      : distance_(distance.size(), kUnreached) {
    slots_.reset(distance.size());
    for (std::uint32_t v = 0; v < distance.size(); ++v) {
      const std::uint32_t before = random.below(3);
      for (std::uint32_t i = 0; i < before; ++i) keep(v, random.unit(), kNumber + 1 + i);
      if (distance[v] < kUnreached) keep(v, distance[v], kNumber);
      if (random.below(4) == 0) keep(v, random.unit(), kNumber - 1);
    }
  }

  [[nodiscard]] FrontDistances distances() const { return FrontDistances(distance_, &slots_); }

 private:
  void keep(std::uint32_t vertex, double distance, std::uint32_t source) {
    Slot last = vertex;
    while (slots_.next[last] != kNone) last = slots_.next[last];
    if (slots_.source[last] == kNone) {
      slots_.source[last] = source;
      distance_[last] = distance;
      return;
    }
    (void)slots_.add(vertex, last, source);
    distance_.push_back(distance);
  }

  std::vector<double> distance_;
  SourceSlots slots_;
};

// Arrivals over the same sides, by lanes and one by one.
std::size_t check_arrivals(const Triangulation& surface, const std::vector<double>& distance,
                           const FrontDistances& distances, const std::vector<Start>& starts) {
  constexpr std::size_t kLanes = ArrivalLanes::kLanes;
  std::size_t compared = 0;
  for (std::size_t first = 0; first + kLanes <= starts.size(); first += kLanes) {
    std::array<Halfedge, kLanes> bases{};
    for (std::size_t i = 0; i < kLanes; ++i) bases[i] = starts[first + i].base;
    std::array<std::uint32_t, kLanes> sources{};
    sources.fill(distances.has_several_sources() ? AmongOthers::kNumber : 0);
    for (const Vectors vectors : vectors_here()) {
      ArrivalLanes lanes{};
      arrive_lanes(surface.faces, distances, bases, sources.data(), vectors, lanes);
      for (std::size_t i = 0; i < kLanes; ++i) {
        const FaceRecord& face = surface.faces[face_of(bases[i])];
        const std::uint32_t c = corner_of(bases[i]);
        const Arrival one = arrive(distance[face.vertex[c]], distance[face.vertex[next_corner(c)]],
                                   face.apex_over(c));
        CHECK(lanes.distance[i] == one.distance);
        CHECK(lanes.crossing[i] == (one.which == Fig4::a   ? static_cast<float>(one.crossing)
                                    : one.which == Fig4::b ? ArrivalLanes::kBendsAtTail
                                                           : ArrivalLanes::kBendsAtHead));
        ++compared;
      }
    }
  }
  return compared;
}

// Where BackTrace::over begins, told as the place itself.
TraceStart start_over(const Triangulation& surface, const Start& start) {
  const FaceRecord& face = surface.faces[face_of(start.base)];
  const std::uint32_t c = corner_of(start.base);
  const double length = std::sqrt(face.length2(previous_corner(c)));
  const Vec2 right{length, 0};
  const Vec2 left{face.dot[previous_corner(c)] / length, face.area2 / length};
  const Vec2 aim = right + start.crossing * (left - right);
  return {start.base, face.vertex[c], face.vertex[next_corner(c)], along_ray(aim, right),
          along_ray(aim, left)};
}

struct Counts {
  std::size_t compared = 0;
  std::size_t oriented = 0;  // starts on surfaces that are, and on others
  std::size_t others = 0;
};

void check_traces(const Triangulation& faces, const FrontDistances& distances,
                  const std::vector<Start>& starts, RandomMesh& random, Counts& counts) {
  const std::uint32_t source = distances.has_several_sources() ? AmongOthers::kNumber : 0;
  using enum BackTrace::Candidates;
  using enum BackTrace::Depth;
  for (const BackTrace::Rule rule :
       {BackTrace::Rule{paths, usual}, BackTrace::Rule{virtual_sources, usual},
        BackTrace::Rule{paths, deep}, BackTrace::Rule{virtual_sources, deep}}) {
    const BackTrace one(faces, distances, rule, nullptr, source);
    for (std::size_t first = 0; first < starts.size();) {
      const std::size_t count =
          std::min<std::size_t>(1 + random.below(TraceLanes::kLanes), starts.size() - first);
      for (const Vectors vectors : vectors_here()) {
        TraceLanes lanes;
        std::array<TraceStart, TraceLanes::kLanes> elsewhere{};
        for (std::size_t i = 0; i < count; ++i) {
          const Start& start = starts[first + i];
          elsewhere[i] = start_over(faces, start);
          if (i % 3 == 1 && norm(elsewhere[i].to_right) < kUnreached) {
            lanes.add(elsewhere[i], kUnreached, source);
          } else {
            lanes.add(start.base, start.crossing, kUnreached, source);
          }
        }
        const TraceLanes before = lanes;
        trace_lanes(faces, distances, rule, vectors, lanes);
        for (std::size_t i = 0; i < count; ++i) {
          const Start& start = starts[first + i];
          const double alone = before.begins_elsewhere(i)
                                   ? one.least(elsewhere[i], kUnreached)
                                   : one.over(start.base, start.crossing, kUnreached);
          CHECK(lanes.best[i] == alone);
          ++counts.compared;
        }
      }
      first += count;
    }
  }
}

void check_lanes(const Surface& surface, RandomMesh& random, std::uint32_t source, Counts& counts) {
  Field field =
      surface.field_by(Method::exact, {Source{point_at_vertex(surface.adjacency(), source), 0}});
  // Part of the surface is not yet reached, as in front of a wave.
  for (double& d : field.distance.doubles()) {
    if (d > 0.8 * field.max) d = kUnreached;
  }
  for (const Triangulation& faces :
       {surface.adjacency().triangulation(), surface.adjacency().delaunay()}) {
    const std::vector<Start> starts = starts_on(faces, field.distance.doubles(), random);
    (faces.is_oriented ? counts.oriented : counts.others) += starts.size();
    const AmongOthers among(field.distance.doubles(), random);
    for (const FrontDistances& distances :
         {FrontDistances(field.distance.doubles()), among.distances()}) {
      counts.compared += check_arrivals(faces, field.distance.doubles(), distances, starts);
      check_traces(faces, distances, starts, random, counts);
    }
  }
}

}  // namespace

// To the last bit, so that a distance is the same whatever machine computes it.
TEST_CASE("LanesComputeWhatOneTraceAndOneArrivalDo") {
  Counts counts;
  for (std::uint32_t number = 0; number < 40; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    check_lanes(surface, random, surface.vertex(random.vertex()), counts);
  }
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    RandomMesh random(1);
    const Surface surface(mesh.soup);
    check_lanes(surface, random, surface.vertex(mesh.source), counts);
  }
  // Large enough for traces that are unsure and look far.
  TriangleSoup hills = shapes::terrain(40, 12, 3);
  for (Vec3& p : hills.positions) p.x *= 4;
  RandomMesh random(2);
  const Surface surface(hills);
  check_lanes(surface, random, surface.vertex(800), counts);
  CHECK(counts.compared > 10000);
  // There is a way of its own for these, and one for the others.
  CHECK(counts.oriented > 1000);
  CHECK(counts.others > 1000);
}

// There the ends of an edge have distances by both, and circles round them say nothing.
TEST_CASE("a trace is hardly below the distance where waves from two sides meet") {
  RandomMesh random(fixtures::test_seed());
  Counts counts;
  std::size_t traces = 0;
  std::size_t below = 0;
  for (int round = 0; round < fixtures::all_or(1000, 100); ++round) {
    constexpr std::uint32_t kSide = 24;
    TriangleSoup soup = shapes::plane(kSide, kSide);
    for (Vec3& p : soup.positions) p = p + Vec3{0.5 * random.unit(), 0.5 * random.unit(), 0};
    const Surface sheet(soup);
    // From on the sheet or beside it; the second set out later.
    const auto draw_wave = [&] {
      return Vec3{kSide * (1.5 * random.unit() - 0.25), kSide * (1.5 * random.unit() - 0.25), 0};
    };
    const Vec3 a = draw_wave();
    const Vec3 b = draw_wave();
    const double later = 0.5 * norm(a - b) * random.unit();
    std::vector<double> distance;
    for (const Vec3& p : sheet.mesh().positions()) {
      distance.push_back(std::min(norm(p - a), norm(p - b) + later));
    }
    const Triangulation surface = sheet.adjacency().delaunay();
    if (round % 50 == 0) {
      check_traces(surface, FrontDistances(distance), starts_on(surface, distance, random), random,
                   counts);
    }
    const BackTrace trace(surface, FrontDistances(distance),
                          {BackTrace::Candidates::virtual_sources, BackTrace::Depth::deep});
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
      const FaceRecord& face = surface.faces[f];
      for (std::uint32_t c = 0; c < 3; ++c) {
        const double p = distance[face.vertex[c]];
        const double q = distance[face.vertex[next_corner(c)]];
        const double truth = distance[face.vertex[previous_corner(c)]];
        const Arrival arrival = arrive(p, q, face.apex_over(c));
        if (arrival.which != Fig4::a || truth < std::max(p, q)) continue;
        const double traced = trace.over(halfedge(f, c), arrival.crossing, kUnreached);
        ++traces;
        if (traced < 0.98 * truth) ++below;  // twice what BackTrace::kMostFarther leaves
      }
    }
  }
  MESSAGE(below << " of " << traces << " traces are more than 2 % below");
  CHECK(10'000 * below <= traces);
}
