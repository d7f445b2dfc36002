// The second part of sending out: windows cross the faces beyond their edges.
#include <algorithm>
#include <cmath>

#include "core/exact/domain.h"

namespace geodesic::exact {

// The lists that were gathered cross their faces, and are handed on to the sides beyond.
void Domain::cross_faces() {
  if (!poll_->stopped()) cross_gathered();
  memory_.entering.size = 0;
  memory_.over_faces.clear();
}

void Domain::cross_gathered() {
  for (ListOverFace& list : memory_.over_faces) unfold(list);
  for (ListOverFace& list : memory_.over_faces) find_nearest(list);
  for (const ListOverFace& list : memory_.over_faces) reach_apex(list);
  memory_.over_sides.clear();
  const std::size_t count = memory_.entering.size;
  for (PropagatedWindows& beyond : memory_.beyond) {
    if (!beyond.make_room(count, *poll_)) return;
  }
  for (EquidistantPoints& equidistant : memory_.equidistant) {
    if (!equidistant.make_room(count, *poll_)) return;
    equidistant.size = 0;
  }
  for (const ListOverFace& list : memory_.over_faces) cross_to_sides(list);
  for (const ListOverSide& list : memory_.over_sides) {
    pair_overlaps(state_.vectors, list.first, list.last, list.upwards, list.side.length,
                  memory_.beyond[list.on_right], memory_.equidistant[list.on_right]);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (memory_.equidistant[i].size > 0) {
      find_equidistant_points(state_.vectors, memory_.entering, memory_.beyond[i],
                              memory_.equidistant[i]);
    }
  }
  for (const ListOverSide& list : memory_.over_sides) {
    if (cancelled_after(list.last - list.first)) return;
    hand_on(list);
  }
}

void Domain::unfold(ListOverFace& list) const {
  const std::uint32_t f = face_of(list.base);
  const std::uint32_t c = corner_of(list.base);
  list.base_length = frames().length(f, c);
  list.at_tail = frames().angle(f, c);
  const double left_length = frames().length(f, previous_corner(c));
  list.apex_x = left_length * list.at_tail.cosine;
  list.apex_y = left_length * list.at_tail.sine;
}

// Finds for every entering window where the line to the far corner crosses the base, and the one by
// which that corner is nearest. A window that the line misses leads there round its end; that
// matters only where no window is.
void Domain::find_nearest(ListOverFace& list) {
  EnteringWindows& entering = memory_.entering;
  list.best = find_crossings(state_.vectors, entering, list.first, list.last, list.apex_x,
                             list.apex_y, list.base_length);
  const std::size_t best = list.best;
  list.crossing = std::clamp(entering.crossing[best], entering.begin[best], entering.end[best]);
  const double run = list.crossing - entering.x[best];
  const double rest = list.apex_x - list.crossing;
  list.distance = entering.offset[best] +
                  std::sqrt(run * run + entering.y[best] * entering.y[best]) +
                  std::sqrt(rest * rest + list.apex_y * list.apex_y);
}

void Domain::reach_apex(const ListOverFace& list) {
  const std::uint32_t f = face_of(list.base);
  const std::uint32_t apex_corner = previous_corner(corner_of(list.base));
  const bool among_many = list.last - list.first >= state_.windows_for_early_source;
  hand_way(state_.surface.faces[f].vertex[apex_corner], list.distance,
           {halfedge(f, apex_corner), memory_.entering.pseudo_source[list.best],
            among_many ? 1U : 0U, list.crossing});
}

// Over the sides from the far corner to the base's tail and from the base's head to it. Where
// only the best window may come to one, mostly it does not. Over a face that is a line a ray goes
// on at the place where it came, so that none of them cross, and each goes to the side that has it.
void Domain::cross_to_sides(const ListOverFace& list) {
  const EnteringWindows& entering = memory_.entering;
  propagated_ += list.last - list.first;
  const std::size_t best = list.best;
  if (frames().face(face_of(list.base)).is_flat()) [[unlikely]] {
    cross_to_side(list, false, list.first, list.last);
    cross_to_side(list, true, list.first, list.last);
    return;
  }
  if (best > list.first || entering.begin[best] < entering.crossing[best]) {
    cross_to_side(list, false, list.first, best + 1);
  }
  if (best + 1 < list.last || entering.crossing[best] < entering.end[best]) {
    cross_to_side(list, true, best, list.last);
  }
}

void Domain::cross_to_side(const ListOverFace& list, bool on_right, std::size_t first,
                           std::size_t last) {
  const std::uint32_t f = face_of(list.base);
  const std::uint32_t c = corner_of(list.base);
  Side side = this->side(halfedge(f, on_right ? next_corner(c) : previous_corner(c)), on_right);
  if (side.on_boundary) return;
  // The far corner does not have this round's distances yet, but the list's own.
  const std::uint32_t apex = state_.surface.faces[f].vertex[previous_corner(c)];
  double& at_apex = state_.edges[side.edge].tail == apex ? side.at_tail : side.at_head;
  at_apex = std::min(at_apex, list.distance);
  const CornerAngle angle = on_right ? frames().angle(f, next_corner(c)) : list.at_tail;
  const SideFrame frame{on_right,    side.flipped, list.base_length, angle.cosine,     angle.sine,
                        side.length, side.at_tail, side.at_head,     side.upper_bound, state_.max};
  exact::cross_to_side(state_.vectors, memory_.entering, first, last, frame,
                       memory_.beyond[on_right]);
  // On the left side t grows with the place on the base.
  memory_.over_sides.push_back({side, first, last, on_right, on_right == side.flipped});
}

}  // namespace geodesic::exact
