// Windows on their way over a face, taken apart into columns, so that several are
// computed at a time (windows/propagate_lanes.h). Columns are as long as needed and a little
// longer: lanes work on four numbers whether they are wanted or not.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"

namespace geodesic::exact {

// Beyond the last number of a column there is room for so many.
inline constexpr std::size_t kColumnSlack = 8;

// Windows in the frame of the halfedge whose face they are about to cross, list by list, and
// of a list in the order in which they lie on it.
struct EnteringWindows {
  std::size_t size = 0;
  std::vector<double> begin;
  std::vector<double> end;
  std::vector<double> x;  // the unfolded source
  std::vector<double> y;
  std::vector<double> offset;    // the pseudo-source's
  std::vector<double> crossing;  // where the line from the source to the far corner meets the base
  std::vector<std::uint32_t> pseudo_source;
  std::vector<std::uint32_t> faces;  // crossed so far

  // Room for so many; false if there is none, as the poll then says, too.
  [[nodiscard]] bool make_room(std::size_t count, Poll& poll) {
    const std::size_t room = count + kColumnSlack;
    // The last to grow: if memory ran out halfway, it has not.
    if (faces.size() >= room) return true;
    const std::size_t rounded = std::bit_ceil(room);
    constexpr std::size_t kBytes = 6 * sizeof(double) + 2 * sizeof(std::uint32_t);
    if (!poll.may_take(rounded * kBytes)) return false;
    for (auto* column : {&begin, &end, &x, &y, &offset, &crossing}) column->resize(rounded, 0);
    pseudo_source.resize(rounded, 0);
    faces.resize(rounded, 0);
    return true;
  }
};

// What becomes of a window beyond one side of the face.
inline constexpr std::int64_t kMisses = 0;    // it does not come there
inline constexpr std::int64_t kWhole = 1;     // all of it does
inline constexpr std::int64_t kDoubtful = 2;  // perhaps not all of it is nearer than along the edge

// What becomes of them: windows in the frame of the edge beyond. Numbered like the entering ones.
struct PropagatedWindows {
  std::vector<double> begin;
  std::vector<double> end;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> at_begin;
  std::vector<double> at_end;
  std::vector<double> least;  // distance in the interval
  std::vector<std::int64_t> passes;
  // Not 0: it and the one numbered before are whole, and overlap so that each sticks out on
  // its side. Also 0 for the first, and one beyond the last.
  std::vector<std::int64_t> overlaps;
  std::vector<std::uint32_t> pair;  // then the number of their pair

  // Room for so many, or false as above. What was there need not be there any more.
  [[nodiscard]] bool make_room(std::size_t count, Poll& poll) {
    const std::size_t room = count + kColumnSlack;
    if (pair.size() >= room) return true;
    const std::size_t rounded = std::bit_ceil(room);
    constexpr std::size_t kBytes =
        7 * sizeof(double) + 2 * sizeof(std::int64_t) + sizeof(std::uint32_t);
    if (!poll.may_take(rounded * kBytes)) return false;
    for (auto* column : {&begin, &end, &x, &y, &at_begin, &at_end, &least}) {
      column->assign(rounded, 0);
    }
    passes.assign(rounded, kMisses);
    overlaps.assign(rounded, 0);
    pair.assign(rounded, 0);
    return true;
  }
};

// Pairs of propagated windows that lie one after the other on the edge and overlap, and where in
// the overlap they are equally far.
struct EquidistantPoints {
  std::size_t size = 0;
  std::vector<std::uint32_t> left;
  std::vector<std::uint32_t> right;
  std::vector<double> place;
  std::vector<double> at_left;
  std::vector<double> at_right;
  std::vector<std::int64_t> found;  // not 0: there is one such place, and this is it

  // Room for so many, or false as above. What was there need not be there any more.
  [[nodiscard]] bool make_room(std::size_t count, Poll& poll) {
    const std::size_t room = count + kColumnSlack;
    if (found.size() >= room) return true;
    const std::size_t rounded = std::bit_ceil(room);
    constexpr std::size_t kBytes =
        3 * sizeof(double) + 2 * sizeof(std::uint32_t) + sizeof(std::int64_t);
    if (!poll.may_take(rounded * kBytes)) return false;
    for (auto* column : {&place, &at_left, &at_right}) column->assign(rounded, 0);
    for (auto* column : {&left, &right}) column->assign(rounded, 0);
    found.assign(rounded, 0);
    return true;
  }
};

}  // namespace geodesic::exact
