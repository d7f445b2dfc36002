// The parts of exact propagation that have answers of their own: envelopes of windows
// and the queue.
#include "tests/fixtures/windows.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/vec2.h"
#include "core/exact/queue.h"
#include "core/field/field.h"
#include "core/windows/envelope.h"
#include "core/windows/window_pool.h"

using namespace geodesic;
using namespace geodesic::exact;
using fixtures::least_at;
using fixtures::window;

namespace {

double fraction(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

}  // namespace

TEST_CASE("AWindowNearerInTheMiddleTakesOnlyTheMiddle") {
  const std::vector<PseudoSource> pseudo_sources{{0, kNone, 0}, {3.9, 1, 0}};
  // From far below, nearly level; from near below, but 3.9 late.
  const Window level = window(pseudo_sources, 0, 0, 10, 5, 5);
  const Window dip = window(pseudo_sources, 1, 0, 10, 5, 0.1);
  for (const bool level_first : {true, false}) {
    std::vector<Window> merged;
    const Window old = level_first ? level : dip;
    const Window fresh = level_first ? dip : level;
    merge({&old, 1}, {&fresh, 1}, pseudo_sources, 10, merged);
    REQUIRE(merged.size() == 3);
    CHECK(merged[0].pseudo_source == 0);
    CHECK(merged[1].pseudo_source == 1);
    CHECK(merged[2].pseudo_source == 0);
    CHECK(merged[0].end == merged[1].begin);
    CHECK(merged[1].begin + merged[1].end == doctest::Approx(10));
    CHECK(merged[1].at_begin == doctest::Approx(merged[0].at_end).epsilon(1e-12));
    CHECK(merged[2].at_begin == doctest::Approx(merged[1].at_end).epsilon(1e-12));
  }
}

TEST_CASE("InATieTheOldWindowStays") {
  const std::vector<PseudoSource> pseudo_sources{{1, kNone, 0}, {1, 1, 1}};
  const Window old = window(pseudo_sources, 0, 1, 9, 4, 2);
  const Window same = window(pseudo_sources, 1, 0, 8, 4, 2);
  std::vector<Window> merged;
  merge({&old, 1}, {&same, 1}, pseudo_sources, 10, merged);
  REQUIRE(merged.size() == 2);
  CHECK(merged[0].pseudo_source == 1);
  CHECK(merged[0].end == 1);
  CHECK(merged[1].pseudo_source == 0);
  CHECK(merged[1].begin == 1);
  CHECK(merged[1].end == 9);
}

TEST_CASE("WindowsOfOneSourceThatTouchBecomeOne") {
  const std::vector<PseudoSource> pseudo_sources{{1, kNone, 0}};
  std::vector<Window> list;
  std::vector<Window> scratch;
  append(list, window(pseudo_sources, 0, 1, 4, 5, 2), pseudo_sources, 10, scratch);
  append(list, window(pseudo_sources, 0, 4, 6, 5, 2), pseudo_sources, 10, scratch);
  append(list, window(pseudo_sources, 0, 7, 8, 5, 2), pseudo_sources, 10, scratch);
  REQUIRE(list.size() == 2);
  CHECK(list[0].begin == 1);
  CHECK(list[0].end == 6);
  CHECK(list[1].begin == 7);
}

TEST_CASE("LightBentByLessThanMattersIsTheSame") {
  // A vertex at (0, 0) of this frame parts the light: beyond it the right part comes from a
  // source turned about it. How far that moves a distance grows with the width.
  const std::vector<PseudoSource> pseudo_sources{{2, kNone, 0}};
  const auto parts = [&](double turn, double width) {
    const Window left = window(pseudo_sources, 0, -1, 0, 0.5, 3);
    const Vec2 source{0.5 * std::cos(turn) + 3 * std::sin(turn),
                      3 * std::cos(turn) - 0.5 * std::sin(turn)};
    const Window right = window(pseudo_sources, 0, 0, width, source.x, source.y);
    return is_as_good(left, right.begin, right.end, right.at_begin, right.at_end, 2);
  };
  CHECK(parts(0, 1));
  CHECK(parts(1e-13, 0.1));
  CHECK(!parts(1e-12, 1));
  CHECK(parts(1e-12, 0.01));
  CHECK(!parts(1e-6, 0.01));
  CHECK(!parts(-1e-6, 0.01));
}

TEST_CASE("AnEnvelopeIsTheLeastEverywhere") {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::vector<PseudoSource> pseudo_sources;
    std::vector<Window> all;
    std::vector<Window> envelope;
    std::vector<Window> scratch;
    for (std::uint32_t i = 0; i < 12; ++i) {
      pseudo_sources.push_back({seed % 3 == 0 ? 0 : 2 * fraction(random), i, 0});
      const double a = fraction(random);
      const double b = fraction(random);
      if (a == b) continue;
      const double depth = seed % 2 == 0 ? fraction(random) : 0.01 * fraction(random);
      const Window w = window(pseudo_sources, i, std::min(a, b), std::max(a, b),
                              3 * fraction(random) - 1, depth);
      all.push_back(w);
      if (i % 2 == 0) {
        append(envelope, w, pseudo_sources, 1, scratch);
      } else {
        merge(envelope, {&w, 1}, pseudo_sources, 1, scratch);
        envelope.swap(scratch);
      }
    }
    for (std::size_t i = 0; i + 1 < envelope.size(); ++i) {
      CHECK(envelope[i].end <= envelope[i + 1].begin + 1e-12);
    }
    for (int i = 0; i < 200; ++i) {
      const double place = fraction(random);
      const double least = least_at(all, pseudo_sources, place);
      if (least == kUnreached) {
        CHECK(least_at(envelope, pseudo_sources, place) == kUnreached);
      } else {
        CHECK(std::abs(least_at(envelope, pseudo_sources, place) - least) <= 1e-11);
      }
    }
  }
}

TEST_CASE("AnEndOfTheEdgeTakesWhatIsNearerAlongTheEdge") {
  const std::vector<PseudoSource> pseudo_sources{{0, kNone, 0}};
  const auto clipped = [&](double at_tail, double at_head) {
    Window w = window(pseudo_sources, 0, 0, 8, 4, 3);  // 5 from both ends
    const bool left = clip_at_ends(w, 0, 8, at_tail, at_head);
    return std::pair{left, w};
  };
  CHECK(clipped(5, 5).first);
  CHECK(clipped(5, 5).second.begin == 0);
  CHECK(clipped(5, 5).second.end == 8);
  // 1 + u = sqrt((4 - u)^2 + 9) at u = 2.4
  CHECK(clipped(1, 5).second.begin == doctest::Approx(2.4).epsilon(1e-14));
  CHECK(clipped(1, 5).second.at_begin == doctest::Approx(3.4).epsilon(1e-14));
  CHECK(clipped(5, 1).second.end == doctest::Approx(5.6).epsilon(1e-14));
  // A tail so near that all of the edge is nearer by it.
  Window steep = window(pseudo_sources, 0, 0, 8, -20, 3);
  CHECK(!clip_at_ends(steep, 0, 8, 10, kUnreached));
}

TEST_CASE("TheQueueServesByBucketsInOrder") {
  std::mt19937 random(1);
  BucketQueue queue;
  for (const double spread : {10.0, 3000.0, 1e7, 1e19}) {
    CAPTURE(spread);
    queue.reset(5, 0.5);
    std::vector<double> left;
    const auto push = [&](double key) {
      queue.push({key, 0, Waiting::What::edge});
      left.push_back(key);
    };
    for (int i = 0; i < 200; ++i) push(5 + spread * std::pow(fraction(random), 6));
    std::vector<Waiting> taken;
    int pushed = 200;
    for (std::uint64_t next = queue.next(); next != BucketQueue::kNever; next = queue.next()) {
      queue.go_to(next);
      const std::size_t count = queue.count_now();
      queue.take(taken);
      CHECK(taken.size() == count);
      CHECK(queue.count_now() == 0);
      for (const Waiting& waiting : taken) {
        const double least = *std::min_element(left.begin(), left.end());
        // Within a bucket any order, beyond 2^52 buckets too.
        if (least < 1e15) {
          CHECK(waiting.key <= least + 0.5 + 1e-9 * least);
          CHECK(queue.now() <= least);
        }
        left.erase(std::find(left.begin(), left.end(), waiting.key));
        if (pushed < 1000) {
          push(waiting.key + spread * std::pow(fraction(random), 6));
          ++pushed;
        }
      }
    }
    CHECK(left.empty());
  }
}

TEST_CASE("ThePoolHandsOutBlocksThatDoNotOverlap") {
  WindowPool pool;
  const Cancel never;
  Poll poll(never);
  std::mt19937 random(2);
  for (int round = 0; round < 2; ++round) {
    struct Block {
      Window* windows;
      std::uint32_t capacity;
      std::uint32_t mark;
    };
    std::vector<Block> blocks;
    for (std::uint32_t i = 0; i < 3000; ++i) {
      if (random() % 3 != 0 || blocks.empty()) {
        const std::uint32_t size = 1 + random() % (i % 500 == 0  ? 20000U
                                                   : i % 50 == 0 ? 1500U
                                                                 : 20U);
        const std::uint32_t capacity = WindowPool::capacity_for(size);
        REQUIRE(capacity >= size);
        blocks.push_back({pool.take(capacity, poll), capacity, i});
        for (std::uint32_t w = 0; w < capacity; ++w) blocks.back().windows[w].pseudo_source = i;
      } else {
        std::swap(blocks[random() % blocks.size()], blocks.back());
        const Block block = blocks.back();
        bool whole = true;
        for (std::uint32_t w = 0; w < block.capacity; ++w) {
          whole = whole && block.windows[w].pseudo_source == block.mark;
        }
        CHECK(whole);
        pool.give_back(block.windows, block.capacity);
        blocks.pop_back();
      }
    }
    pool.reset(poll, 1);
  }
}

// Hundreds of megabytes take long to give back: not all at once.
TEST_CASE("ThePoolGivesMemoryBackInPiecesAndLeavesOffWhenToldTo") {
  WindowPool pool;
  std::uint32_t asked = 0;
  std::uint32_t patience = 3;
  const Cancel cancel([&] { return ++asked > patience; });
  const auto fill = [&] {
    std::vector<Window*> blocks;
    const Cancel never;
    Poll poll(never);
    for (int i = 0; i < 400; ++i) blocks.push_back(pool.take(4096, poll));
    for (std::uint32_t i = 0; i < 400; ++i) blocks[i][4095].pseudo_source = i;
    for (std::uint32_t i = 0; i < 400; ++i) REQUIRE(blocks[i][4095].pseudo_source == i);
  };
  fill();
  Poll impatient(cancel);
  pool.reset(impatient, 1);
  CHECK(impatient.stopped());
  CHECK(asked == 4);
  // Nothing is lost with what was not given back.
  fill();
  patience = 1'000'000;
  asked = 0;
  Poll patient(cancel);
  pool.reset(patient, 1);
  CHECK(!patient.stopped());
  CHECK(asked > 300);
  asked = 0;
  pool.reset(patient, 1);
  CHECK(asked == 0);
  fill();
}
