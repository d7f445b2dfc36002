// Lists of windows over a face: against the plane they are drawn in, and the same bits
// from every kind of vectors.
#include "core/windows/propagate_lanes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/vec2.h"
#include "core/field/field.h"
#include "core/windows/envelope.h"

using namespace geodesic;
using namespace geodesic::exact;

namespace {

std::vector<Vectors> vectors_of_this_processor() {
  std::vector<Vectors> all{Vectors::plain};
  if (best_vectors() != Vectors::plain) all.push_back(Vectors::avx2);
  return all;
}

template <class Columns>
void make_room(Columns& columns, std::size_t count) {
  const Cancel never;
  Poll poll(never);
  REQUIRE(columns.make_room(count, poll));
}

double share(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

// A face over its base and light that comes to it from below.
struct Scene {
  double base;
  Vec2 apex;
  EnteringWindows entering;

  explicit Scene(std::mt19937& random) : base(0.5 + share(random)) {
    apex = {base * (1.6 * share(random) - 0.3), 0.2 + share(random)};
    const std::size_t count = 1 + random() % 30;
    make_room(entering, count);
    entering.size = count;
    std::vector<double> ends{0};
    for (std::size_t i = 0; i < count; ++i) ends.push_back(ends.back() + 0.1 + share(random));
    for (std::size_t i = 0; i < count; ++i) {
      entering.begin[i] = base * ends[i] / ends.back();
      entering.end[i] = base * ends[i + 1] / ends.back();
      entering.x[i] = base * (3 * share(random) - 1);
      entering.y[i] = share(random) < 0.1 ? 0 : 4 * share(random);
      entering.offset[i] = 3 * share(random);
    }
  }
  [[nodiscard]] double distance(std::size_t i, const Vec2& to) const {
    return entering.offset[i] + std::hypot(to.x - entering.x[i], to.y + entering.y[i]);
  }
};

SideFrame side_of(const Scene& scene, bool on_right, bool flipped) {
  const Vec2 corner = on_right ? Vec2{scene.base, 0} : Vec2{0, 0};
  const Vec2 along = scene.apex - corner;
  const double length = norm(along);
  const double cosine = (on_right ? -along.x : along.x) / length;
  return {on_right, flipped,    scene.base, cosine,     scene.apex.y / length,
          length,   kUnreached, kUnreached, kUnreached, kUnreached};
}

// The place of the plane that is so far along a side, by its edge's own count.
Vec2 place_on(const Scene& scene, const SideFrame& side, double along) {
  const Vec2 corner = side.on_right ? Vec2{scene.base, 0} : Vec2{0, 0};
  const double t = (side.flipped ? side.length - along : along) / side.length;
  return corner + t * (scene.apex - corner);
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b, std::size_t first, std::size_t last) {
  return std::equal(a.begin() + static_cast<std::ptrdiff_t>(first),
                    a.begin() + static_cast<std::ptrdiff_t>(last),
                    b.begin() + static_cast<std::ptrdiff_t>(first));
}

}  // namespace

TEST_CASE("OfAListTheNearestBeamToTheFarCornerIsFound") {
  std::mt19937 random(1);
  for (int round = 0; round < 500; ++round) {
    Scene scene(random);
    const auto by_way = [&](std::size_t i) {
      const double straight =
          (scene.entering.x[i] * scene.apex.y + scene.apex.x * scene.entering.y[i]) /
          (scene.entering.y[i] + scene.apex.y);
      const Vec2 at{std::clamp(straight, scene.entering.begin[i], scene.entering.end[i]), 0};
      return scene.distance(i, at) + norm(scene.apex - at);
    };
    double least = kUnreached;
    for (std::size_t i = 0; i < scene.entering.size; ++i) least = std::min(least, by_way(i));
    std::vector<double> crossings;
    for (const Vectors vectors : vectors_of_this_processor()) {
      const std::size_t best = find_crossings(vectors, scene.entering, 0, scene.entering.size,
                                              scene.apex.x, scene.apex.y, scene.base);
      REQUIRE(best < scene.entering.size);
      CHECK(by_way(best) <= least * (1 + 1e-14));
      if (crossings.empty()) crossings = scene.entering.crossing;
      CHECK(same(crossings, scene.entering.crossing, 0, scene.entering.size));
    }
  }
}

TEST_CASE("ChildrenAreTheLightOfTheirBeamsOnTheOtherSide") {
  std::mt19937 random(2);
  std::size_t whole = 0;
  for (int round = 0; round < 500; ++round) {
    Scene scene(random);
    const std::size_t count = scene.entering.size;
    (void)find_crossings(Vectors::plain, scene.entering, 0, count, scene.apex.x, scene.apex.y,
                         scene.base);
    for (int kind = 0; kind < 4; ++kind) {
      const SideFrame side = side_of(scene, (kind & 1) != 0, (kind & 2) != 0);
      PropagatedWindows first;
      for (const Vectors vectors : vectors_of_this_processor()) {
        PropagatedWindows beyond;
        make_room(beyond, count);
        cross_to_side(vectors, scene.entering, 0, count, side, beyond);
        if (first.begin.empty()) first = beyond;
        CHECK(same(first.passes, beyond.passes, 0, count));
        for (auto column :
             {&PropagatedWindows::begin, &PropagatedWindows::end, &PropagatedWindows::x,
              &PropagatedWindows::y, &PropagatedWindows::at_begin, &PropagatedWindows::at_end,
              &PropagatedWindows::least}) {
          CHECK(same(first.*column, beyond.*column, 0, count));
        }
      }
      for (std::size_t i = 0; i < count; ++i) {
        if (first.passes[i] == kMisses) continue;
        CHECK(first.begin[i] >= -1e-12);
        CHECK(first.end[i] <= side.length + 1e-12);
        if (first.passes[i] == kWhole) ++whole;
        for (const auto& [along, at] : {std::pair{first.begin[i], first.at_begin[i]},
                                        std::pair{first.end[i], first.at_end[i]}}) {
          const Vec2 place = place_on(scene, side, along);
          CHECK(std::abs(at - scene.distance(i, place)) < 1e-12);
          // The line from the source comes through the beam.
          const double through = scene.entering.x[i] + (place.x - scene.entering.x[i]) *
                                                           scene.entering.y[i] /
                                                           (place.y + scene.entering.y[i]);
          if (scene.entering.y[i] == 0 || place.y < 1e-9) continue;
          CHECK(through > scene.entering.begin[i] - 1e-9);
          CHECK(through < scene.entering.end[i] + 1e-9);
        }
      }
    }
  }
  CHECK(whole > 5000);
}

TEST_CASE("NeighboursShareAnOverlapWhereTheyAreEquallyFar") {
  std::mt19937 random(3);
  std::size_t crossed = 0;
  std::size_t lost = 0;
  for (int round = 0; round < 3000; ++round) {
    Scene scene(random);
    const std::size_t count = scene.entering.size;
    // As in a real list, neighbours agree where they meet; in some, one is much nearer.
    for (std::size_t i = 1; i < count && round % 3 != 0; ++i) {
      const Vec2 meet{scene.entering.begin[i], 0};
      scene.entering.offset[i] += scene.distance(i - 1, meet) - scene.distance(i, meet);
    }
    (void)find_crossings(Vectors::plain, scene.entering, 0, count, scene.apex.x, scene.apex.y,
                         scene.base);
    const bool flipped = round % 2 == 0;
    const SideFrame side = side_of(scene, round % 4 < 2, flipped);
    const bool upwards = side.on_right == flipped;
    EquidistantPoints first;
    for (const Vectors vectors : vectors_of_this_processor()) {
      PropagatedWindows beyond;
      EquidistantPoints equidistant;
      make_room(beyond, count);
      make_room(equidistant, count);
      cross_to_side(vectors, scene.entering, 0, count, side, beyond);
      pair_overlaps(vectors, 0, count, upwards, side.length, beyond, equidistant);
      find_equidistant_points(vectors, scene.entering, beyond, equidistant);
      if (first.place.empty()) first = equidistant;
      REQUIRE(equidistant.size == first.size);
      CHECK(same(first.found, equidistant.found, 0, equidistant.size));
      CHECK(same(first.left, equidistant.left, 0, equidistant.size));
      for (std::size_t t = 0; t < equidistant.size; ++t) {
        if (equidistant.found[t] == 0) continue;
        CHECK(first.place[t] == equidistant.place[t]);
        CHECK(first.at_left[t] == equidistant.at_left[t]);
        const std::size_t left = equidistant.left[t];
        const std::size_t right = equidistant.right[t];
        const double low = beyond.begin[right];
        const double high = beyond.end[left];
        REQUIRE(low < high);
        const auto at = [&](std::size_t i, double along) {
          return scene.distance(i, place_on(scene, side, along));
        };
        // To the left of the place the left one is nearer, to its right the right one.
        const double slack = 1e-12 * beyond.at_end[left];
        for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
          const double along = low + part * (high - low);
          const double more = at(right, along) - at(left, along);
          if (along < equidistant.place[t]) CHECK(more >= -slack);
          if (along > equidistant.place[t]) CHECK(more <= slack);
        }
        CHECK(std::abs(equidistant.at_left[t] - at(left, equidistant.place[t])) < slack);
        CHECK(std::abs(equidistant.at_right[t] - at(right, equidistant.place[t])) < slack);
        ++(equidistant.place[t] > low && equidistant.place[t] < high ? crossed : lost);
      }
    }
  }
  CHECK(crossed > 500);
  CHECK(lost > 100);
}
