#include "core/exact/envelope.h"

#include <algorithm>
#include <cmath>

#include "core/exact/window_comparison.h"

namespace geodesic::exact {
namespace {

void push(std::vector<Window>& list, const Window& window, PseudoSources roots, double length) {
  const double offset = roots[window.root].offset;
  if (too_narrow(window, length, offset)) return;
  if (!list.empty() && is_continued_by(list.back(), window, offset, length)) {
    list.back().end = window.end;
    list.back().at_end = window.at_end;
    return;
  }
  list.push_back(window);
}

// The same for a window that is in the list already, as its last.
void keep_last(std::vector<Window>& list, PseudoSources roots, double length) {
  const Window& window = list.back();
  const double offset = roots[window.root].offset;
  if (too_narrow(window, length, offset)) {
    list.pop_back();
    return;
  }
  if (list.size() < 2) return;
  Window& before = list[list.size() - 2];
  if (before.root != window.root || !is_continued_by(before, window, offset, length)) return;
  before.end = window.end;
  before.at_end = window.at_end;
  list.pop_back();
}

// Puts pieces of windows together as they come, from left to right.
class Pieces {
 public:
  Pieces(std::vector<Window>& list, PseudoSources roots, double length)
      : list_(list), roots_(roots), length_(length) {}
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
    made.root = w.root;
    made.from = w.from;
    made.propagated = w.propagated;
    keep_last(list_, roots_, length_);
  }
  std::vector<Window>& list_;
  PseudoSources roots_;
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
void settle(const Duel& duel, Pieces& pieces) {
  const double g_low = duel.at_low_b - duel.at_low_a;
  const double g_high = duel.at_high_b - duel.at_high_a;
  const bool b_low = g_low < -duel.tie;
  const bool b_high = g_high < -duel.tie;
  const auto add_a = [&](double begin, double end, double at_begin, double at_end) {
    pieces.add(duel.a, begin, end, at_begin, at_end);
  };
  const auto add_b = [&](double begin, double end, double at_begin, double at_end) {
    pieces.add(duel.b, begin, end, at_begin, at_end);
  };
  if ((b_low && g_high > duel.tie) || (b_high && g_low > duel.tie)) {
    const auto [tie, at_tie_a, at_tie_b] = find_tie(duel, duel.low, duel.high, g_low, g_high);
    if (b_low) {
      add_b(duel.low, tie, duel.at_low_b, at_tie_b);
      add_a(tie, duel.high, at_tie_a, duel.at_high_a);
    } else {
      add_a(duel.low, tie, duel.at_low_a, at_tie_a);
      add_b(tie, duel.high, at_tie_b, duel.at_high_b);
    }
    return;
  }
  Roots inside{};
  if (b_low || b_high) {
    if (!wins_inside(duel, -1, inside)) {
      add_b(duel.low, duel.high, duel.at_low_b, duel.at_high_b);
      return;
    }
    add_b(duel.low, inside.first, duel.at_low_b, duel.b.at(inside.first, duel.offset_b));
    add_a(inside.first, inside.second, duel.a.at(inside.first, duel.offset_a),
          duel.a.at(inside.second, duel.offset_a));
    add_b(inside.second, duel.high, duel.b.at(inside.second, duel.offset_b), duel.at_high_b);
    return;
  }
  if (!wins_inside(duel, 1, inside)) {
    add_a(duel.low, duel.high, duel.at_low_a, duel.at_high_a);
    return;
  }
  add_a(duel.low, inside.first, duel.at_low_a, duel.a.at(inside.first, duel.offset_a));
  add_b(inside.first, inside.second, duel.b.at(inside.first, duel.offset_b),
        duel.b.at(inside.second, duel.offset_b));
  add_a(inside.second, duel.high, duel.a.at(inside.second, duel.offset_a), duel.at_high_a);
}

// What nearly always happens where the light of two pseudo-sources meets: one window
// is nearer up to somewhere in the overlap, the next one from there. False, and nothing
// done, when it is not so.
bool cross_over(Window& left, const Window& right, PseudoSources roots, double length,
                std::vector<Window>& list) {
  if (!(left.begin < right.begin && left.end < right.end)) return false;
  const double offset_left = roots[left.root].offset;
  const double offset_right = roots[right.root].offset;
  const Duel duel{left,
                  right,
                  offset_left,
                  offset_right,
                  right.begin,
                  left.end,
                  left.at(right.begin, offset_left),
                  left.at_end,
                  right.at_begin,
                  right.at(left.end, offset_right),
                  kTie * left.at_end};
  const double g_low = duel.at_low_b - duel.at_low_a;
  const double g_high = duel.at_high_b - duel.at_high_a;
  if (!(g_low > duel.tie && g_high < -duel.tie)) return false;
  const auto [tie, at_tie_left, at_tie_right] = find_tie(duel, duel.low, duel.high, g_low, g_high);
  Window after = right;
  after.begin = tie;
  after.at_begin = at_tie_right;
  left.end = tie;
  left.at_end = at_tie_left;
  if (too_narrow(left, length, offset_left)) list.pop_back();
  push(list, after, roots, length);
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

void append_overlapping(std::vector<Window>& list, const Window& window, PseudoSources roots,
                        double length, std::vector<Window>& scratch) {
  auto first = list.end();
  while (first != list.begin() && (first - 1)->end > window.begin) --first;
  if (list.end() - first == 1 && cross_over(*first, window, roots, length, list)) return;
  merge(std::span<const Window>(first, list.end()), {&window, 1}, roots, length, scratch);
  list.erase(first, list.end());
  for (const Window& piece : scratch) push(list, piece, roots, length);
}

void append_merged(std::span<const Window> old, std::span<const Window> fresh, PseudoSources roots,
                   double length, std::vector<Window>& merged) {
  Pieces pieces(merged, roots, length);
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
    const double distance = rest.window->at(at, roots[rest.window->root].offset);
    pieces.add(*rest.window, rest.begin, at, rest.at_begin, distance);
    rest.begin = at;
    rest.at_begin = distance;
  };
  while (i < old.size() && j < fresh.size()) {
    const double touch = kTouch * length;
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
    const double offset_a = roots[a.window->root].offset;
    const double offset_b = roots[b.window->root].offset;
    const double at_high_a =
        high == a.window->end ? a.window->at_end : a.window->at(high, offset_a);
    const double at_high_b =
        high == b.window->end ? b.window->at_end : b.window->at(high, offset_b);
    const double tie = kTie * std::max(a.at_begin, at_high_a);
    settle({*a.window, *b.window, offset_a, offset_b, low, high, a.at_begin, at_high_a, b.at_begin,
            at_high_b, tie},
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

}  // namespace geodesic::exact
