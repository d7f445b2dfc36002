// Where two lists of windows on one edge meet: most often the last windows of one and the
// first of the other overlap, and there is one place up to which the one is nearer and from
// which the other is. Then nothing need be merged: the two are cut there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/windows/envelope.h"
#include "core/windows/window.h"

namespace geodesic::exact {

// What became of two windows that overlap.
enum class Trimming : std::uint8_t {
  cut,         // both are left
  old_gone,    // nothing is left of the one that was there
  fresh_gone,  // nothing is left of the one that came
  not_plain,   // nothing was done: a window is nearer in two places, or amid the other
};

// Cuts two windows that overlap to where each is the nearer one; where they are equally near `old`
// is. `fresh_ends` is whether the fresh one is to lie behind the old one on the edge, or before it.
[[nodiscard]] Trimming trim(Window& old, Window& fresh, bool fresh_ends,
                            PseudoSources pseudo_sources, double length);

// What is left of two lists once they were trimmed.
struct Trimmed {
  std::span<Window> old;
  std::span<Window> fresh;
  bool fresh_ends;  // the fresh ones lie behind the old ones, or else before them
  bool plain;       // they do not overlap any more
};

// Trims fresh windows to the old ones of an edge that they overlap, both of them sorted.
[[nodiscard]] Trimmed trim(std::span<Window> old, std::span<Window> fresh,
                           PseudoSources pseudo_sources, double length);

}  // namespace geodesic::exact
