// Lists of windows over a face: against the plane they are drawn in, and the same bits
// from every kind of vectors.
#include "core/exact/propagate_lanes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/vec2.h"
#include "core/exact/envelope.h"
#include "core/field/field.h"

using namespace geodesic;
using namespace geodesic::exact;

namespace {

std::vector<Vectors> vectors_of_this_processor() {
  std::vector<Vectors> all{Vectors::plain};
  if (best_vectors() != Vectors::plain) all.push_back(Vectors::avx2);
  return all;
}

double share(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

// A face over its base and light that comes to it from below.
struct Scene {
  double base;
  Vec2 apex;
  Beams beams;

  explicit Scene(std::mt19937& random) : base(0.5 + share(random)) {
    apex = {base * (1.6 * share(random) - 0.3), 0.2 + share(random)};
    const std::size_t count = 1 + random() % 30;
    beams.make_room(count);
    beams.size = count;
    std::vector<double> ends{0};
    for (std::size_t i = 0; i < count; ++i) ends.push_back(ends.back() + 0.1 + share(random));
    for (std::size_t i = 0; i < count; ++i) {
      beams.begin[i] = base * ends[i] / ends.back();
      beams.end[i] = base * ends[i + 1] / ends.back();
      beams.x[i] = base * (3 * share(random) - 1);
      beams.y[i] = share(random) < 0.1 ? 0 : 4 * share(random);
      beams.offset[i] = 3 * share(random);
    }
  }
  [[nodiscard]] double distance(std::size_t i, const Vec2& to) const {
    return beams.offset[i] + std::hypot(to.x - beams.x[i], to.y + beams.y[i]);
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
      const double straight = (scene.beams.x[i] * scene.apex.y + scene.apex.x * scene.beams.y[i]) /
                              (scene.beams.y[i] + scene.apex.y);
      const Vec2 at{std::clamp(straight, scene.beams.begin[i], scene.beams.end[i]), 0};
      return scene.distance(i, at) + norm(scene.apex - at);
    };
    double least = kUnreached;
    for (std::size_t i = 0; i < scene.beams.size; ++i) least = std::min(least, by_way(i));
    std::vector<double> crossings;
    for (const Vectors vectors : vectors_of_this_processor()) {
      const std::size_t best = find_crossings(vectors, scene.beams, 0, scene.beams.size,
                                              scene.apex.x, scene.apex.y, scene.base);
      REQUIRE(best < scene.beams.size);
      CHECK(by_way(best) <= least * (1 + 1e-14));
      if (crossings.empty()) crossings = scene.beams.crossing;
      CHECK(same(crossings, scene.beams.crossing, 0, scene.beams.size));
    }
  }
}

TEST_CASE("ChildrenAreTheLightOfTheirBeamsOnTheOtherSide") {
  std::mt19937 random(2);
  std::size_t whole = 0;
  for (int round = 0; round < 500; ++round) {
    Scene scene(random);
    const std::size_t count = scene.beams.size;
    (void)find_crossings(Vectors::plain, scene.beams, 0, count, scene.apex.x, scene.apex.y,
                         scene.base);
    for (int kind = 0; kind < 4; ++kind) {
      const SideFrame side = side_of(scene, (kind & 1) != 0, (kind & 2) != 0);
      Children first;
      for (const Vectors vectors : vectors_of_this_processor()) {
        Children children;
        children.make_room(count);
        cross_to_side(vectors, scene.beams, 0, count, side, children);
        if (first.begin.empty()) first = children;
        CHECK(same(first.passes, children.passes, 0, count));
        for (auto column : {&Children::begin, &Children::end, &Children::x, &Children::y,
                            &Children::at_begin, &Children::at_end, &Children::least}) {
          CHECK(same(first.*column, children.*column, 0, count));
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
          const double through = scene.beams.x[i] + (place.x - scene.beams.x[i]) *
                                                        scene.beams.y[i] /
                                                        (place.y + scene.beams.y[i]);
          if (scene.beams.y[i] == 0 || place.y < 1e-9) continue;
          CHECK(through > scene.beams.begin[i] - 1e-9);
          CHECK(through < scene.beams.end[i] + 1e-9);
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
    const std::size_t count = scene.beams.size;
    // As in a real list, neighbours agree where they meet; in some, one is much nearer.
    for (std::size_t i = 1; i < count && round % 3 != 0; ++i) {
      const Vec2 meet{scene.beams.begin[i], 0};
      scene.beams.offset[i] += scene.distance(i - 1, meet) - scene.distance(i, meet);
    }
    (void)find_crossings(Vectors::plain, scene.beams, 0, count, scene.apex.x, scene.apex.y,
                         scene.base);
    const bool flipped = round % 2 == 0;
    const SideFrame side = side_of(scene, round % 4 < 2, flipped);
    const bool upwards = side.on_right == flipped;
    Ties first;
    for (const Vectors vectors : vectors_of_this_processor()) {
      Children children;
      Ties ties;
      children.make_room(count);
      ties.make_room(count);
      cross_to_side(vectors, scene.beams, 0, count, side, children);
      pair_overlaps(vectors, 0, count, upwards, side.length, children, ties);
      find_ties(vectors, scene.beams, children, ties);
      if (first.place.empty()) first = ties;
      REQUIRE(ties.size == first.size);
      CHECK(same(first.found, ties.found, 0, ties.size));
      CHECK(same(first.left, ties.left, 0, ties.size));
      for (std::size_t t = 0; t < ties.size; ++t) {
        if (ties.found[t] == 0) continue;
        CHECK(first.place[t] == ties.place[t]);
        CHECK(first.at_left[t] == ties.at_left[t]);
        const std::size_t left = ties.left[t];
        const std::size_t right = ties.right[t];
        const double low = children.begin[right];
        const double high = children.end[left];
        REQUIRE(low < high);
        const auto at = [&](std::size_t i, double along) {
          return scene.distance(i, place_on(scene, side, along));
        };
        // To the left of the place the left one is nearer, to its right the right one.
        const double slack = 1e-12 * children.at_end[left];
        for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
          const double along = low + part * (high - low);
          const double more = at(right, along) - at(left, along);
          if (along < ties.place[t]) CHECK(more >= -slack);
          if (along > ties.place[t]) CHECK(more <= slack);
        }
        CHECK(std::abs(ties.at_left[t] - at(left, ties.place[t])) < slack);
        CHECK(std::abs(ties.at_right[t] - at(right, ties.place[t])) < slack);
        ++(ties.place[t] > low && ties.place[t] < high ? crossed : lost);
      }
    }
  }
  CHECK(crossed > 500);
  CHECK(lost > 100);
}
