// Lists of windows trimmed together, against the envelope of all that is in them.
#include "core/windows/trim_windows.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

#include "core/windows/envelope.h"
#include "tests/fixtures/windows.h"

using namespace geodesic;
using namespace geodesic::exact;
using fixtures::least_at;

namespace {

struct SeamLists {
  std::vector<PseudoSource> pseudo_sources;
  std::vector<Window> old;
  std::vector<Window> fresh;
};

// Two envelopes of random windows between 0 and 1, of which each may reach anywhere, or of
// which the fresh one is to lie on one side.
SeamLists random_lists(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
  SeamLists lists;
  std::vector<Window> scratch;
  const double shift = seed % 3 == 0 ? 0 : (seed % 3 == 1 ? 0.4 : -0.4);
  for (std::uint32_t i = 0; i < 10; ++i) {
    lists.pseudo_sources.push_back({seed % 2 == 0 ? 1 : 1 + 0.1 * unit(), i, 0});
    const bool is_old = i % 2 == 0;
    const double from = is_old ? 0 : shift;
    const double a = from + unit();
    const double b = from + unit();
    if (a == b) continue;
    const double x = 3 * unit() - 1;
    Window w =
        fixtures::window(lists.pseudo_sources, i, std::min(a, b), std::max(a, b), x, 2 * unit());
    w.propagated = is_old;
    append(is_old ? lists.old : lists.fresh, w, lists.pseudo_sources, 1, scratch);
  }
  return lists;
}

}  // namespace

TEST_CASE("SewnListsAreTheEnvelopeOfBoth") {
  std::uint32_t plain = 0;
  std::uint32_t overlapped = 0;
  for (std::uint32_t seed = 0; seed < 3000; ++seed) {
    CAPTURE(seed);
    SeamLists lists = random_lists(seed);
    if (lists.old.empty() || lists.fresh.empty()) continue;
    std::vector<Window> all;
    merge(lists.old, lists.fresh, lists.pseudo_sources, 1, all);
    const Trimmed trimmed = trim(lists.old, lists.fresh, lists.pseudo_sources, 1);
    plain += trimmed.plain;
    overlapped += all.size() != lists.old.size() + lists.fresh.size();
    std::vector<Window> left;
    if (trimmed.plain) {
      left.assign(trimmed.old.begin(), trimmed.old.end());
      left.insert(trimmed.fresh_ends ? left.end() : left.begin(), trimmed.fresh.begin(),
                  trimmed.fresh.end());
      for (std::size_t i = 1; i < left.size(); ++i) CHECK(left[i - 1].end <= left[i].begin + 1e-12);
    } else {
      // What was done so far does not change the envelope.
      merge(trimmed.old, trimmed.fresh, lists.pseudo_sources, 1, left);
    }
    for (int i = 0; i < 100; ++i) {
      const double place = -0.4 + 1.8 * i / 100;
      const double truth = least_at(all, lists.pseudo_sources, place);
      const double least = least_at(left, lists.pseudo_sources, place);
      CAPTURE(place);
      REQUIRE((truth == kUnreached) == (least == kUnreached));
      if (truth != kUnreached) CHECK(least == doctest::Approx(truth).epsilon(1e-12));
    }
    for (const Window& w : left) {
      CHECK(w.at_begin ==
            doctest::Approx(w.at(w.begin, lists.pseudo_sources[w.pseudo_source].offset)));
      CHECK(w.at_end == doctest::Approx(w.at(w.end, lists.pseudo_sources[w.pseudo_source].offset)));
      CHECK(w.propagated == (w.pseudo_source % 2 == 0));
    }
  }
  CHECK(plain > 300);
  CHECK(overlapped > 1000);
}

TEST_CASE("ASeamIsAtTheTie") {
  const std::vector<PseudoSource> pseudo_sources{{0, kNone, 0}, {0, 1, 0}};
  const auto window = [](std::uint32_t pseudo_source, double begin, double end, double x) {
    Window w{begin, end, x, 3, 0, 0, pseudo_source, 0, 0, false};
    w.at_begin = w.at(begin, 0);
    w.at_end = w.at(end, 0);
    return w;
  };
  for (const bool fresh_ends : {true, false}) {
    Window left = window(0, 0, 6, 1);
    Window right = window(1, 3, 9, 8);
    CHECK(trim(fresh_ends ? left : right, fresh_ends ? right : left, fresh_ends, pseudo_sources,
               10) == Trimming::cut);
    CHECK(left.end == doctest::Approx(4.5).epsilon(1e-12));
    CHECK(right.begin == left.end);
  }
  // A tie everywhere: the old one stays.
  Window old = window(0, 0, 6, 1);
  Window same = window(1, 2, 5, 1);
  CHECK(trim(old, same, true, pseudo_sources, 10) == Trimming::fresh_gone);
  CHECK(old.end == 6);
}
