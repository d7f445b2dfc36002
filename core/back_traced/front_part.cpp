#include "core/back_traced/front_part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/back_traced/part_trace.h"
#include "core/base/lane_arithmetic.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// Corners at a vertex, but for a few vertices: with as many always, no branch depends on
// how many there are, which nobody could predict.
constexpr std::size_t kMostCorners = 8;

// A traced distance above its estimate by more than this part of the base edge: the
// estimate was of two sources, or the trace took the wrong side of something.
constexpr double kSuspicious = 0.02;

// Of so many neighbours the ways are continued; few vertices have more.
constexpr std::size_t kMostNeighbours = 16;

// At corner c, the side to the nearer of the other two corners, and the farther one: at
// [2c + 1] where the next corner is nearer than the previous one, else at [2c].
constexpr std::array<std::uint8_t, 6> kNearerSide{2, 0, 0, 1, 1, 2};
constexpr std::array<std::uint8_t, 6> kFartherCorner{1, 2, 2, 0, 0, 1};

}  // namespace

void trace_back(const FrontState& front, std::span<const Slot> slots, std::span<double> best,
                FrontRoom& room, Poll& poll) {
  PartTrace trace(front, slots, best, room, poll);
  trace.trace_known();
  trace.ask_other_faces();
  // On scans, which are large and smooth, that takes a twentieth of the time, and little is gained.
  if (front.rule.depth == BackTrace::Depth::deep) trace.ask_neighbours();
}

void PartTrace::trace_known() {
  const std::size_t at_once = std::min(kMostCorners, surface_.all_corners.size());
  for (std::uint32_t i = 0; i < part_.size(); ++i) {
    if (poll_.cancelled()) break;
    // For the spread: a few at a time, for many at once would have to queue.
    const std::size_t begin = std::min<std::size_t>(surface_.corner_begin[vertex(i)],
                                                    surface_.all_corners.size() - at_once);
    for (const std::uint32_t corner : surface_.all_corners.subspan(begin, at_once)) {
      __builtin_prefetch(&surface_.faces[face_of(corner)]);
    }
    const FrontVertex& known = front_.vertices[part_[i]];
    double& best = best_[i];
    best = distances_.in(part_[i]);
    if (known.base == kNone) continue;  // straight from the source
    const bool bends_at_tail = known.crossing == ArrivalLanes::kBendsAtTail;
    if (!bends_at_tail && known.crossing != ArrivalLanes::kBendsAtHead) {
      trace(i, known.base, known.crossing, best);
      continue;
    }
    const FaceRecord& face = surface_.faces[face_of(known.base)];
    const std::uint32_t c = corner_of(known.base);
    const std::uint32_t n = next_corner(c);
    const auto length = [&](std::uint32_t side) {
      return surface_.is_even ? std::sqrt(std::max(face.length2(side), 0.0))
                              : side_not_below(face, side);
    };
    const double by_tail = distances_.at(face.vertex[c], source(i)) + length(previous_corner(c));
    const double by_head = distances_.at(face.vertex[n], source(i)) + length(n);
    best = std::min({best, by_tail, by_head});
    // At a pinched vertex only one end may have a distance.
    if (!(std::max(by_tail, by_head) < kUnreached)) continue;
    trace_past_vertex(i, face.vertex[bends_at_tail ? c : n]);
  }
  flush();
}

void PartTrace::flush() {
  if (traces_.count == 0) return;
  trace_lanes(surface_, distances_, front_.rule, front_.vectors, traces_, &front_.crowds);
  for (std::size_t i = 0; i < traces_.count; ++i) {
    double& best = best_[traced_[i]];
    best = std::min(best, traces_.best[i]);
  }
  traces_.clear();
}

void PartTrace::ask_other_faces() {
  std::vector<Halfedge>& bases = room_.bases;
  std::vector<FrontRoom::Ask>& asks = room_.asks;
  bases.clear();
  asks.clear();
  room_.sources_of_bases.clear();
  for (std::uint32_t i = 0; i < part_.size(); ++i) {
    if (!is_doubtful(part_[i], best_[i])) continue;
    const auto distance = [&, number = source(i)](std::uint32_t v) {
      return distances_.at(v, number);
    };
    for (const std::uint32_t corner : surface_.corners(vertex(i))) {
      if (poll_.cancelled()) break;
      const std::uint32_t n = next_corner(corner_of(corner));
      const Halfedge base = halfedge(face_of(corner), n);
      const FaceRecord& face = surface_.faces[face_of(corner)];
      if (base == front_.vertices[part_[i]].base) continue;
      if (!(distance(face.vertex[n]) + distance(face.vertex[next_corner(n)]) < kUnreached))
        continue;
      bases.push_back(base);
      room_.sources_of_bases.push_back(source(i));
      asks.push_back({i, best_[i]});
    }
  }
  arrive_over_bases(front_, bases.size(), room_, poll_,
                    [&](std::size_t at, double distance, float crossing) {
                      const bool straight = crossing >= 0 && crossing <= 1;
                      const auto [place, best] = asks[at];
                      if (straight && distance < best) trace(place, bases[at], crossing, best);
                    });
  flush();
}

void PartTrace::ask_neighbours() {
  for (std::uint32_t i = 0; i < part_.size(); ++i) {
    const double before = best_[i];
    if (!is_doubtful(part_[i], before)) continue;
    std::array<std::uint32_t, kMostNeighbours> asked{};
    std::size_t count = 0;
    for (const std::uint32_t corner : surface_.corners(vertex(i))) {
      if (poll_.cancelled()) break;
      const FaceRecord& face = surface_.faces[face_of(corner)];
      for (const std::uint32_t c :
           {next_corner(corner_of(corner)), previous_corner(corner_of(corner))}) {
        const std::uint32_t neighbour = face.vertex[c];
        if (!(distances_.at(neighbour, source(i)) < before)) continue;
        const auto end = asked.begin() + static_cast<std::ptrdiff_t>(count);
        if (count == asked.size() || std::find(asked.begin(), end, neighbour) != end) continue;
        asked[count++] = neighbour;
      }
    }
    for (const std::uint32_t neighbour : std::span(asked).first(count)) {
      trace_past_vertex(i, neighbour);
    }
  }
  flush();
}

bool PartTrace::is_doubtful(Slot slot, double best) const {
  const FrontVertex& known = front_.vertices[slot];
  if (known.base == kNone) return false;
  const double base2 = surface_.faces[face_of(known.base)].length2(corner_of(known.base));
  // Of one source estimates have no offset.
  const double offset =
      distances_.has_several_sources() ? front_.sources[distances_.source_of(slot)].offset : 0;
  const double above = best - (known.estimate - offset);
  return above > 0 && above * above > kSuspicious * kSuspicious * base2;
}

namespace {

// The corners at the vertices of these slots, one after the other; how many there are. Behind them
// is what nobody asked for.
std::size_t list_corners(const FrontState& front, std::span<const Slot> slots, FrontRoom& room) {
  const Triangulation& surface = front.surface;
  const bool are_several = front.distances.has_several_sources();
  const std::span<const std::uint32_t> all = surface.all_corners;
  std::vector<std::uint32_t>& corners = room.corners;
  std::vector<std::uint32_t>& sources = room.sources_of_corners;
  sources.clear();
  std::size_t count = 0;
  for (const Slot slot : slots) {
    const std::uint32_t v = front.distances.vertex_of(slot);
    const std::size_t begin = surface.corner_begin[v];
    const std::size_t at_vertex = surface.corner_begin[v + 1] - begin;
    const std::size_t room_for = count + std::max(at_vertex, kMostCorners);
    if (corners.size() < room_for) corners.resize(2 * room_for);
    if (at_vertex <= kMostCorners && begin + kMostCorners <= all.size()) [[likely]] {
      std::memcpy(corners.data() + count, all.data() + begin, kMostCorners * sizeof(std::uint32_t));
    } else {
      std::memcpy(corners.data() + count, all.data() + begin, at_vertex * sizeof(std::uint32_t));
    }
    count += at_vertex;
    if (are_several) sources.resize(count, front.distances.source_of(slot));
  }
  return count;
}

template <bool kSeveralSources>
std::size_t list_bases_of(const FrontState& front, std::size_t corners, FrontRoom& room) {
  const FaceRecord* const faces = front.surface.faces.data();
  const FrontDistances distances = front.distances;
  const FrontVertex* const known = front.vertices.data();
  std::uint32_t* const sources = room.sources_of_bases.data();
  Halfedge* const bases = room.bases.data();
  std::size_t count = 0;
  for (std::size_t i = 0; i < corners; ++i) {
    const std::uint32_t corner = room.corners[i];
    const FaceRecord& face = faces[face_of(corner)];
    const std::uint32_t c = corner_of(corner);
    const std::uint32_t source = kSeveralSources ? room.sources_of_corners[i] : 0;
    const auto distance = [&](std::uint32_t v) { return distances.at<kSeveralSources>(v, source); };
    const double own = distance(face.vertex[c]);
    const double at_ahead = distance(face.vertex[lanes::kNextCorner[c]]);
    const double at_behind = distance(face.vertex[lanes::kPreviousCorner[c]]);
    const double nearer = std::min(at_ahead, at_behind);
    const double farther = std::max(at_ahead, at_behind);
    // Without a branch, which nobody could predict.
    const std::size_t which = 2 * c + static_cast<std::size_t>(at_ahead < at_behind);
    bases[count] = corner - c + kNearerSide[which];
    if constexpr (kSeveralSources) sources[count] = source;
    const std::uint32_t apex = face.vertex[kFartherCorner[which]];
    __builtin_prefetch(&known[apex]);
    count += static_cast<std::size_t>((nearer < kUnreached) & (own < farther));
  }
  return count;
}

}  // namespace

std::size_t list_bases(const FrontState& front, std::span<const Slot> slots, FrontRoom& room) {
  const std::size_t corners = list_corners(front, slots, room);
  room.bases.resize(corners + ArrivalLanes::kLanes);
  if (!front.distances.has_several_sources()) return list_bases_of<false>(front, corners, room);
  room.sources_of_bases.resize(corners + ArrivalLanes::kLanes);
  return list_bases_of<true>(front, corners, room);
}

}  // namespace geodesic
