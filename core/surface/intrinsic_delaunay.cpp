#include "core/surface/intrinsic_delaunay.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/large_array.h"
#include "core/base/polled_fill.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/surface/corner_lists.h"
#include "core/surface/intrinsic_faces.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// Some faces that follow one another. What changes in them concerns no others.
struct Block {
  std::size_t number;
  std::uint32_t begin;
  std::uint32_t end;

  [[nodiscard]] bool has(Halfedge h) const { return face_of(h) - begin < end - begin; }
};

struct DelaunayBuilder {
  // In each block by itself, with whoever helps; then across them.
  void flip_edges(std::span<const Vec3> positions, Poll& poll);
  [[nodiscard]] std::uint64_t flip_within(const Block& block, SideLengths& lengths, Poll& poll);
  [[nodiscard]] std::uint64_t flip_across(SideLengths& lengths, Poll& poll);
  // Flips those that wait, and the sides of what they lie in as these come to want it. Returns how
  // many. `is_wanted(h)`, and `may_flip(h)` of one that is: whether a flip is to be tried.
  template <class IsWanted, class MayFlip>
  std::uint64_t flip_waiting(std::vector<Halfedge>& waiting, std::size_t face_count,
                             SideLengths& lengths, IsWanted is_wanted, MayFlip may_flip,
                             Poll& poll);
  // Whether a flip reads and writes no faces but the block's. The halfedge's two are.
  [[nodiscard]] bool is_within(const Block& block, Halfedge h) const;

  [[nodiscard]] Triangulation view() const {
    return {faces.all(), {}, {}, is_oriented, false, has_flat_faces, is_crowded};
  }
  [[nodiscard]] bool is_wanted(Halfedge h) const;
  void leave_for_later(Halfedge h) {
    later[face_of(h) / kBits] |= std::uint64_t{1} << (face_of(h) % kBits);
  }

  static constexpr std::uint32_t kBits = 64;
  static_assert(kBlock % kBits == 0);

  LargeArray<FaceRecord> faces;
  bool is_oriented = false;
  bool is_crowded = false;
  bool has_flat_faces = false;
  std::uint64_t flips = 0;
  // A bit a face: one of its edges may want to be flipped, which its block could not do alone.
  std::vector<std::uint64_t> later = {};
};

}  // namespace

Result<IntrinsicDelaunay> IntrinsicDelaunay::build(const Triangulation& mesh,
                                                   std::span<const Vec3> positions,
                                                   const Cancel& cancel) {
  Poll poll(cancel);
  DelaunayBuilder result{.faces = LargeArray<FaceRecord>(mesh.faces.size(), poll),
                         .is_oriented = mesh.is_oriented,
                         .is_crowded = mesh.is_crowded,
                         .has_flat_faces = mesh.has_flat_faces};
  std::vector<std::uint32_t> corner_begin;
  std::vector<std::uint32_t> corners;
  run_in_blocks(result.faces.size(), poll,
                [&](std::size_t, std::size_t begin, std::size_t end, Poll& asked) {
                  if (asked.ask()) return;
                  std::copy(mesh.faces.begin() + static_cast<std::ptrdiff_t>(begin),
                            mesh.faces.begin() + static_cast<std::ptrdiff_t>(end),
                            result.faces.all().begin() + static_cast<std::ptrdiff_t>(begin));
                });
  if (!poll.ask()) result.flip_edges(positions, poll);
  cancel.report(0.8);
  if (result.flips != 0 && !poll.stopped()) {
    list_corners(result.faces.all(), mesh.corner_begin.size() - 1, corner_begin, corners, poll);
  } else {
    polled_copy(corner_begin, mesh.corner_begin, poll);
    polled_copy(corners, mesh.all_corners, poll);
  }
  const SideExtent sides = extent_of_sides(result.faces.all(), poll);
  if (poll.stopped()) return fail_stopped(cancel);
  return IntrinsicDelaunay(Parts{.faces = std::move(result.faces).share(),
                                 .corner_begin = SharedArray(std::move(corner_begin)),
                                 .corners = SharedArray(std::move(corners)),
                                 .is_oriented = result.is_oriented,
                                 .is_crowded = result.is_crowded,
                                 .is_even = sides.is_even(),
                                 .has_flat_faces = result.has_flat_faces,
                                 .longest2 = sides.longest2,
                                 .flips = result.flips});
}

bool IntrinsicDelaunay::can_flip(const Triangulation& faces, Halfedge h) {
  const Halfedge across = faces.ring(h);
  if (across == h || faces.ring(across) != h || face_of(across) == face_of(h)) return false;
  return faces.faces[face_of(h)].vertex[previous_corner(corner_of(h))] !=
         faces.faces[face_of(across)].vertex[previous_corner(corner_of(across))];
}

namespace {

// The two products whose sum is the excess.
std::array<double, 2> cotangents(const Triangulation& faces, Halfedge h) {
  const Halfedge across = faces.ring(h);
  const FaceRecord& one = faces.faces[face_of(h)];
  const FaceRecord& other = faces.faces[face_of(across)];
  return {one.dot[previous_corner(corner_of(h))] * other.area2,
          other.dot[previous_corner(corner_of(across))] * one.area2};
}

}  // namespace

double IntrinsicDelaunay::excess(const Triangulation& faces, Halfedge h) {
  const auto [one, other] = cotangents(faces, h);
  return one + other;
}

double IntrinsicDelaunay::excess_rounding(const Triangulation& faces, Halfedge h) {
  const auto [one, other] = cotangents(faces, h);
  return tolerance::kDelaunay * (std::abs(one) + std::abs(other));
}

bool DelaunayBuilder::is_wanted(Halfedge h) const {
  const Triangulation faces = view();
  if (faces.ring(h) == h) return false;
  return IntrinsicDelaunay::excess(faces, h) < -IntrinsicDelaunay::excess_rounding(faces, h) ||
         (has_flat_faces && is_between_flats(faces.faces, h));
}

void DelaunayBuilder::flip_edges(std::span<const Vec3> positions, Poll& poll) {
  SideLengths lengths(positions, faces.size(), poll);
  if (poll.stopped()) return;
  later.assign(faces.size() / kBits + 1, 0);
  std::vector<std::uint64_t> flips_in(count_blocks(faces.size()));
  run_in_blocks(faces.size(), poll,
                [&](std::size_t number, std::size_t begin, std::size_t end, Poll& asked) {
                  const Block block{number, static_cast<std::uint32_t>(begin),
                                    static_cast<std::uint32_t>(end)};
                  flips_in[number] = flip_within(block, lengths, asked);
                });
  for (const std::uint64_t some : flips_in) flips += some;
  if (!poll.stopped()) flips += flip_across(lengths, poll);
}

std::uint64_t DelaunayBuilder::flip_within(const Block& block, SideLengths& lengths, Poll& poll) {
  const auto is_wanted_here = [&](Halfedge h) {
    if (block.has(view().ring(h))) return is_wanted(h);
    leave_for_later(h);
    return false;
  };
  std::vector<Halfedge> waiting;
  for (std::uint32_t f = block.begin; f < block.end && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const Halfedge across = view().ring(h);
      if ((h < across || !block.has(across)) && is_wanted_here(h)) waiting.push_back(h);
    }
  }
  return flip_waiting(
      waiting, block.end - block.begin, lengths, is_wanted_here,
      [&](Halfedge h) {
        const bool may = is_within(block, h) && lengths.has_room(block.number, 2);
        if (!may) leave_for_later(h);
        return may;
      },
      poll);
}

std::uint64_t DelaunayBuilder::flip_across(SideLengths& lengths, Poll& poll) {
  const auto is_wanted_anywhere = [this](Halfedge h) { return is_wanted(h); };
  std::vector<Halfedge> waiting;
  for (std::size_t at = 0; at < later.size() && !poll.cancelled(); ++at) {
    for (std::uint64_t word = later[at]; word != 0; word &= word - 1) {
      const auto f = static_cast<std::uint32_t>(at * kBits) +
                     static_cast<std::uint32_t>(std::countr_zero(word));
      for (std::uint32_t c = 0; c < 3; ++c) {
        if (is_wanted(halfedge(f, c))) waiting.push_back(halfedge(f, c));
      }
    }
  }
  return flip_waiting(
      waiting, faces.size(), lengths, is_wanted_anywhere, [](Halfedge) { return true; }, poll);
}

template <class IsWanted, class MayFlip>
std::uint64_t DelaunayBuilder::flip_waiting(std::vector<Halfedge>& waiting, std::size_t face_count,
                                            SideLengths& lengths, IsWanted is_wanted,
                                            MayFlip may_flip, Poll& poll) {
  const std::uint64_t most = most_flips(face_count);
  std::uint64_t count = 0;
  while (!waiting.empty() && count < most && !poll.cancelled()) {
    const Halfedge h = waiting.back();
    waiting.pop_back();
    if (!is_wanted(h) || !IntrinsicDelaunay::can_flip(view(), h) || !may_flip(h)) continue;
    const std::uint32_t f = face_of(h);
    const std::uint32_t g = face_of(view().ring(h));
    if (!flip_edge(faces.all(), h, lengths)) continue;
    ++count;
    // The new edge is side 1 of both; their other sides have a new angle opposite.
    for (const Halfedge side : {halfedge(f, 0), halfedge(f, 2), halfedge(g, 0), halfedge(g, 2)}) {
      if (is_wanted(side)) waiting.push_back(side);
    }
  }
  return count;
}

bool DelaunayBuilder::is_within(const Block& block, Halfedge h) const {
  const Triangulation faces = view();
  for (const Halfedge base : {h, faces.ring(h)}) {
    for (const std::uint32_t c : {next_corner(corner_of(base)), previous_corner(corner_of(base))}) {
      const Halfedge side = halfedge(face_of(base), c);
      std::size_t count = 0;
      for (Halfedge p = faces.ring(side); p != side; p = faces.ring(p)) {
        if (!block.has(p) || ++count > Triangulation::kCrowd) return false;
      }
    }
  }
  return true;
}

std::size_t IntrinsicDelaunay::bytes() const {
  return sizeof(IntrinsicDelaunay) + parts_.faces.bytes() + parts_.corner_begin.bytes() +
         parts_.corners.bytes();
}

}  // namespace geodesic
