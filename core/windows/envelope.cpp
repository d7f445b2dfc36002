#include "core/windows/envelope.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"
#include "core/windows/window_comparison.h"

namespace geodesic::exact {
namespace {

void push(std::vector<Window>& list, const Window& window, PseudoSources pseudo_sources,
          double length) {
  const double offset = pseudo_sources[window.pseudo_source].offset;
  if (too_narrow(window, length, offset)) return;
  if (!list.empty() && is_continued_by(list.back(), window, offset, length)) {
    list.back().end = window.end;
    list.back().at_end = window.at_end;
    list.back().faces = std::max(list.back().faces, window.faces);
    return;
  }
  list.push_back(window);
}

// The same for a window that is in the list already, as its last.
void keep_last(std::vector<Window>& list, PseudoSources pseudo_sources, double length) {
  const Window& window = list.back();
  const double offset = pseudo_sources[window.pseudo_source].offset;
  if (too_narrow(window, length, offset)) {
    list.pop_back();
    return;
  }
  if (list.size() < 2) return;
  Window& before = list[list.size() - 2];
  if (before.pseudo_source != window.pseudo_source ||
      !is_continued_by(before, window, offset, length))
    return;
  before.end = window.end;
  before.at_end = window.at_end;
  before.faces = std::max(before.faces, window.faces);
  list.pop_back();
}

// Puts pieces of windows together as they come, from left to right.
class Pieces {
 public:
  Pieces(std::vector<Window>& list, PseudoSources pseudo_sources, double length)
      : list_(list), pseudo_sources_(pseudo_sources), length_(length) {}
  ~Pieces() { flush(); }
  Pieces(const Pieces&) = delete;
  Pieces& operator=(const Pieces&) = delete;

  void add(const Window& whole, double begin, double end, double at_begin, double at_end) {
    if (!(begin < end)) return;
    if (whole_ != &whole || end_ != begin) {
      flush();
      whole_ = &whole;
      begin_ = begin;
      at_begin_ = at_begin;
    }
    end_ = end;
    at_end_ = at_end;
  }

 private:
  void flush() {
    if (whole_ == nullptr) return;
    // Made where it is to be: a copy at once would wait for every part of it.
    const Window& w = *whole_;
    Window& made = list_.emplace_back();
    made.begin = begin_;
    made.end = end_;
    made.x = w.x;
    made.y = w.y;
    made.at_begin = at_begin_;
    made.at_end = at_end_;
    made.pseudo_source = w.pseudo_source;
    made.from = w.from;
    made.faces = w.faces;
    made.propagated = w.propagated;
    keep_last(list_, pseudo_sources_, length_);
  }
  std::vector<Window>& list_;
  PseudoSources pseudo_sources_;
  double length_;
  const Window* whole_ = nullptr;  // of the piece that may still grow
  double begin_ = 0;
  double end_ = 0;
  double at_begin_ = 0;
  double at_end_ = 0;
};

// What is left of a window while the sweep goes on.
struct Rest {
  const Window* window;
  double begin;
  double at_begin;

  void start(const Window& w) {
    window = &w;
    begin = w.begin;
    at_begin = w.at_begin;
  }
};

// Both windows over their common interval, piece by piece, to the nearer of the two.
void add_nearer(const WindowComparison& comparison, Pieces& pieces) {
  const double g_low = comparison.at_low_b - comparison.at_low_a;
  const double g_high = comparison.at_high_b - comparison.at_high_a;
  const bool b_low = g_low < -comparison.rounding;
  const bool b_high = g_high < -comparison.rounding;
  const auto add_a = [&](double begin, double end, double at_begin, double at_end) {
    pieces.add(comparison.a, begin, end, at_begin, at_end);
  };
  const auto add_b = [&](double begin, double end, double at_begin, double at_end) {
    pieces.add(comparison.b, begin, end, at_begin, at_end);
  };
  if ((b_low && g_high > comparison.rounding) || (b_high && g_low > comparison.rounding)) {
    const auto [place, at_place_a, at_place_b] =
        find_equidistant_point(comparison, comparison.low, comparison.high, g_low, g_high);
    if (b_low) {
      add_b(comparison.low, place, comparison.at_low_b, at_place_b);
      add_a(place, comparison.high, at_place_a, comparison.at_high_a);
    } else {
      add_a(comparison.low, place, comparison.at_low_a, at_place_a);
      add_b(place, comparison.high, at_place_b, comparison.at_high_b);
    }
    return;
  }
  TwoPlaces inside{};
  if (b_low || b_high) {
    if (!is_nearer_inside(comparison, -1, inside)) {
      add_b(comparison.low, comparison.high, comparison.at_low_b, comparison.at_high_b);
      return;
    }
    add_b(comparison.low, inside.first, comparison.at_low_b,
          comparison.b.at(inside.first, comparison.offset_b));
    add_a(inside.first, inside.second, comparison.a.at(inside.first, comparison.offset_a),
          comparison.a.at(inside.second, comparison.offset_a));
    add_b(inside.second, comparison.high, comparison.b.at(inside.second, comparison.offset_b),
          comparison.at_high_b);
    return;
  }
  if (!is_nearer_inside(comparison, 1, inside)) {
    add_a(comparison.low, comparison.high, comparison.at_low_a, comparison.at_high_a);
    return;
  }
  add_a(comparison.low, inside.first, comparison.at_low_a,
        comparison.a.at(inside.first, comparison.offset_a));
  add_b(inside.first, inside.second, comparison.b.at(inside.first, comparison.offset_b),
        comparison.b.at(inside.second, comparison.offset_b));
  add_a(inside.second, comparison.high, comparison.a.at(inside.second, comparison.offset_a),
        comparison.at_high_a);
}

// What nearly always happens where the windows of two pseudo-sources meet: one window
// is nearer up to somewhere in the overlap, the next one from there. False, and nothing
// done, when it is not so.
bool cross_over(Window& left, const Window& right, PseudoSources pseudo_sources, double length,
                std::vector<Window>& list) {
  if (!(left.begin < right.begin && left.end < right.end)) return false;
  const double offset_left = pseudo_sources[left.pseudo_source].offset;
  const double offset_right = pseudo_sources[right.pseudo_source].offset;
  const WindowComparison comparison{left,
                                    right,
                                    offset_left,
                                    offset_right,
                                    right.begin,
                                    left.end,
                                    left.at(right.begin, offset_left),
                                    left.at_end,
                                    right.at_begin,
                                    right.at(left.end, offset_right),
                                    tolerance::kSameDistance * left.at_end};
  const double g_low = comparison.at_low_b - comparison.at_low_a;
  const double g_high = comparison.at_high_b - comparison.at_high_a;
  if (!(g_low > comparison.rounding && g_high < -comparison.rounding)) return false;
  const auto [place, at_place_left, at_place_right] =
      find_equidistant_point(comparison, comparison.low, comparison.high, g_low, g_high);
  Window after = right;
  after.begin = place;
  after.at_begin = at_place_right;
  left.end = place;
  left.at_end = at_place_left;
  if (too_narrow(left, length, offset_left)) list.pop_back();
  push(list, after, pseudo_sources, length);
  return true;
}

}  // namespace

// With u from the interval's beginning, r its distance from the unfolded source and k
// that along the edge less the offset:
//   k + u = sqrt(u^2 - 2 x u + r^2)
void cut_begin(Window& window, double offset, double along_edge) {
  const double r = window.at_begin - offset;
  const double k = along_edge - offset;
  const double u = 0.5 * (window.at_begin - along_edge) * (r + k) / (k + (window.x - window.begin));
  if (!(u > 0 && u < window.end - window.begin)) return;
  window.begin += u;
  window.at_begin = window.at(window.begin, offset);
}

void cut_end(Window& window, double offset, double along_edge) {
  const double r = window.at_end - offset;
  const double k = along_edge - offset;
  const double u = 0.5 * (window.at_end - along_edge) * (r + k) / (k + (window.end - window.x));
  if (!(u > 0 && u < window.end - window.begin)) return;
  window.end -= u;
  window.at_end = window.at(window.end, offset);
}

void append_overlapping(std::vector<Window>& list, const Window& window,
                        PseudoSources pseudo_sources, double length, std::vector<Window>& scratch) {
  auto first = list.end();
  while (first != list.begin() && (first - 1)->end > window.begin) --first;
  if (list.end() - first == 1 && cross_over(*first, window, pseudo_sources, length, list)) return;
  merge(std::span<const Window>(first, list.end()), {&window, 1}, pseudo_sources, length, scratch);
  list.erase(first, list.end());
  for (const Window& piece : scratch) push(list, piece, pseudo_sources, length);
}

// Whatever is looked at has begun, but the analyser does not see that.
// NOLINTBEGIN(clang-analyzer-core.NullDereference)
void append_merged(std::span<const Window> old, std::span<const Window> fresh,
                   PseudoSources pseudo_sources, double length, std::vector<Window>& merged) {
  Pieces pieces(merged, pseudo_sources, length);
  std::size_t i = 0;
  std::size_t j = 0;
  Rest a{};
  Rest b{};
  if (i < old.size()) a.start(old[i]);
  if (j < fresh.size()) b.start(fresh[j]);
  const auto finish = [&](Rest& rest, std::span<const Window> list, std::size_t& at) {
    pieces.add(*rest.window, rest.begin, rest.window->end, rest.at_begin, rest.window->at_end);
    if (++at < list.size()) rest.start(list[at]);
  };
  // The part of a window before the overlap.
  const auto cut = [&](Rest& rest, double at) {
    if (!(rest.begin < at)) return;
    const double distance = rest.window->at(at, pseudo_sources[rest.window->pseudo_source].offset);
    pieces.add(*rest.window, rest.begin, at, rest.at_begin, distance);
    rest.begin = at;
    rest.at_begin = distance;
  };
  while (i < old.size() && j < fresh.size()) {
    const double touch = tolerance::kTouch * length;
    if (a.window->end <= b.begin + touch) {
      b.begin = std::max(b.begin, a.window->end);
      finish(a, old, i);
      continue;
    }
    if (b.window->end <= a.begin + touch) {
      a.begin = std::max(a.begin, b.window->end);
      finish(b, fresh, j);
      continue;
    }
    const double low = std::max(a.begin, b.begin);
    cut(a, low);
    cut(b, low);
    const double high = std::min(a.window->end, b.window->end);
    const double offset_a = pseudo_sources[a.window->pseudo_source].offset;
    const double offset_b = pseudo_sources[b.window->pseudo_source].offset;
    const double at_high_a =
        high == a.window->end ? a.window->at_end : a.window->at(high, offset_a);
    const double at_high_b =
        high == b.window->end ? b.window->at_end : b.window->at(high, offset_b);
    const double rounding = rounding_of(*a.window, *b.window, std::max(a.at_begin, at_high_a));
    add_nearer({*a.window, *b.window, offset_a, offset_b, low, high, a.at_begin, at_high_a,
                b.at_begin, at_high_b, rounding},
               pieces);
    a.begin = b.begin = high;
    a.at_begin = at_high_a;
    b.at_begin = at_high_b;
    const bool a_done = high == a.window->end;
    const bool b_done = high == b.window->end;
    if (a_done && ++i < old.size()) a.start(old[i]);
    if (b_done && ++j < fresh.size()) b.start(fresh[j]);
  }
  while (i < old.size()) finish(a, old, i);
  while (j < fresh.size()) finish(b, fresh, j);
}
// NOLINTEND(clang-analyzer-core.NullDereference)

}  // namespace geodesic::exact
