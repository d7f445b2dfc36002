// Windows on their way over the surface. Mitchell, Mount and Papadimitriou 1987,
// section 4; Surazhsky et al. 2005, section 3, with three differences:
//   - what waits in the queue is an edge, with all that has arrived there, not a
//     window, and a list of windows crosses a face at once; some edges that are about
//     as far go together, step by step;
//   - an edge keeps the windows of both directions in one lower envelope;
//   - of a list that crosses a face, only the window that is nearest to the far
//     corner goes on over both of the other sides: shortest paths do not cross, so
//     those to its left only go left and those to its right only go right.
//
// Every distance here is the length of a real way from a source, so cutting off
// what is farther than another distance is always right, in whatever order.
//
// With a tolerance, distances are those of a field with more sources than there are: a
// vertex that is reached may become one, starting a little earlier than it was reached
// (bend_at). What its windows then outrun are the many narrow ones that came past it on
// both sides. More sources only lower a field, so it is never above the true one; and
// `allowance` says by how much it may be below: a distance and what it is above there make
// the length of a real path. A vertex becomes a source only as far as that sum stays within
// the tolerance.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/exact/envelope.h"
#include "core/exact/frames.h"
#include "core/exact/propagate_lanes.h"
#include "core/exact/queue.h"
#include "core/exact/trim_windows.h"
#include "core/exact/window.h"
#include "core/exact/window_columns.h"
#include "core/exact/window_pool.h"
#include "core/field/field.h"
#include "core/field/window_table.h"
#include "core/surface/adjacency.h"

namespace geodesic::exact {

// How a vertex got its distance, for knowing where to it bends: through which
// corner, and where the straight line back meets the side opposite, counted from
// the corner after that one.
struct ArrivalAtVertex {
  std::uint32_t corner;
  bool among_many;  // one of many windows on that side led there
  double crossing;
};

// A side of a face, to which windows come through the face.
struct Side {
  Halfedge from;
  std::uint32_t edge;
  bool flipped;  // what comes is counted from the edge's head
  bool on_boundary;
  double length;
  double at_tail;  // the distances of the edge's ends
  double at_head;
  double upper_bound;  // of the edge
};

// A list of windows on its way over a face: those from `first` to before `last` of the entering
// ones.
struct ListOverFace {
  Halfedge base;
  std::size_t first;
  std::size_t last;
  // Of the face, unfolded: its base from (0, 0) to (base_length, 0).
  double base_length = 0;
  CornerAngle at_tail{};
  double apex_x = 0;
  double apex_y = 0;
  // The window by which the far corner is nearest, where it crosses the base, and how far it is.
  std::size_t best = 0;
  double crossing = 0;
  double distance = 0;
};

// Windows on their way over one side of a face, the left or the right one: those from `first`
// to before `last` of those beyond it.
struct ListOverSide {
  Side side;
  std::size_t first;
  std::size_t last;
  bool on_right;
  bool upwards;  // their numbers ascend along the edge
};

// The propagated windows of a list on one side, in the order in which they lie on its edge.
struct PropagatedOrder {
  std::size_t first;  // those to come
  std::size_t last;
  bool upwards;  // their numbers ascend

  [[nodiscard]] std::size_t left() const { return last - first; }
  [[nodiscard]] std::size_t next() const { return upwards ? first : last - 1; }
  void skip(std::size_t count) { (upwards ? first : last) += upwards ? count : 0 - count; }
};

// Windows that come to an edge: the first of `list`.
struct FreshList {
  std::vector<Window>& list;
  std::size_t size;
  double least;  // none of them is nearer anywhere
};

// A face round a vertex, turned past from one of its two sides there to the other.
struct FanFace {
  std::uint32_t corner;
  bool from_next;  // entered over the side towards the corner's next vertex
  double begin;    // angles from the way back at which it begins and ends
  double end;
};

// Memory of one propagation, kept for the next.
struct PropagationMemory {
  Frames frames;
  WindowPool pool;
  BucketQueue queue;
  std::vector<PseudoSource> pseudo_sources;
  std::vector<double> offsets;  // the pseudo-sources' own
  std::vector<ArrivalAtVertex> arrivals;
  std::vector<Bends> bends;
  std::vector<double> emitted;    // the distance at which a vertex last sent out windows
  std::vector<double> allowance;  // of the pseudo-source of a vertex's distance; with a tolerance
  EnteringWindows entering;
  std::vector<ListOverFace> over_faces;
  std::vector<ListOverSide> over_sides;
  // By the side: left and right.
  std::array<PropagatedWindows, 2> beyond;
  std::array<EquidistantPoints, 2> equidistant;
  std::vector<Window> fresh;  // windows that come to an edge
  std::vector<Window> scratch;
  std::vector<Window> waiting;  // of an edge whose faces are crossed some at a time
  std::vector<FanFace> fan;
};

class Propagation {
 public:
  // Distances are exact, or above by at most the part `tolerance` of the true one; at most 1.
  // Those that are not above `max` are found.
  //
  // Fills `field.distance` and, when it has a place for each vertex,
  // `field.nearest_source`. All must outlive this object, which is of no use if the
  // poll says to stop.
  //
  // Windows run over `surface`: the faces of the mesh or any others that cut it up. Of others
  // no windows may be kept, and sources lie at vertices. It asks the poll where one step is long:
  // at a vertex or an edge of thousands of faces.
  Propagation(const Adjacency& adjacency, const Triangulation& surface, PropagationMemory& memory,
              Field& field, double max, double tolerance, bool keep_windows, Poll& poll);

  // Only the windows of these faces of the mesh are to be kept. Before the first source.
  void keep_windows_of(std::span<const std::uint32_t> faces);

  // Behind so many windows on an edge a vertex may become a source; for
  // tests, which want it to happen on small meshes.
  void set_windows_for_early_source(std::size_t windows) { windows_for_early_source_ = windows; }

  // Sends out a source's windows.
  void start(const Source& source, std::uint32_t number);

  // Takes the next step, of a few edges; false when there is nothing left to do.
  [[nodiscard]] bool step();

  // Vertices with a path_length() below this have their final one.
  [[nodiscard]] double final_below() const { return memory_.queue.now() / (1 + tolerance_); }
  // The length of the path to a vertex that is known.
  [[nodiscard]] double path_length(std::uint32_t v) const { return distance_[v] + allowance(v); }

  // Lets distances through along edges where no window came, as a last resort
  // against rounding. True when that sent out something new. Incomplete if the poll
  // says to stop.
  [[nodiscard]] bool relax_along_edges(Poll& poll);

  // With a tolerance: makes the distances the lengths of paths, above the true ones by at
  // most that part. The last thing to ask. Incomplete if the poll says to stop.
  void raise_to_paths(Poll& poll);

  // The windows left, for each face that they see into and that has all of its own; with a
  // tolerance their ways are raised to paths, too. Not all of them if the poll says to stop.
  [[nodiscard]] VisibleIntervals visible_intervals(Poll& poll) const;

  // Gives the windows' memory back: the last thing to do. Not all if the poll says to stop.
  void drop_windows(Poll& poll);

  // Vertices that have a distance, though perhaps not the final one.
  [[nodiscard]] std::uint64_t reached() const { return reached_; }

  // Windows that have crossed a face; for tests and measurements.
  [[nodiscard]] std::uint64_t propagated() const { return propagated_; }

 private:
  // Of the poll's steps: few of ordinary lists, and of lists of any length one in some
  // microseconds.
  static constexpr std::size_t kWindowsAStep = 16;

  [[nodiscard]] std::uint32_t add_pseudo_source(const PseudoSource& pseudo_source);

  // Counts so many windows as gone through. True once the computation should stop.
  [[nodiscard]] bool cancelled_after(std::size_t windows) {
    return poll_.cancelled_after(1 + windows / kWindowsAStep);
  }
  // Whether a list may have room for so many.
  template <class T>
  [[nodiscard]] bool may_hold(const std::vector<T>& list, std::size_t count) {
    return count <= list.capacity() || poll_.may_take(count * sizeof(T));
  }

  // exact/propagation.cpp: windows set out from their edges.
  void set_out(std::uint32_t e);
  void drop_overtaken(Edge& edge);
  void join_propagated(Edge& edge);
  [[nodiscard]] std::span<Window> take_waiting(std::span<Window> windows);
  void load_entering(std::span<const Window> windows, Halfedge h);
  void keep_sources_on_line(std::size_t first, double length);

  // exact/cross_faces.cpp: they cross the faces beyond.
  void cross_faces();
  void unfold(ListOverFace& list) const;
  void find_nearest(ListOverFace& list);
  void reach_apex(const ListOverFace& list);
  void cross_to_sides(const ListOverFace& list);
  void cross_to_side(const ListOverFace& list, bool on_right, std::size_t first, std::size_t last);

  // exact/join_windows.cpp: they join the windows on the edges that they come to.
  void arrive(const ListOverSide& list);
  [[nodiscard]] bool add_plain(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh);
  [[nodiscard]] Trimming trim_last(Window* first, Window*& last, double length);
  void add_with_care(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh);
  [[nodiscard]] Side side(Halfedge h, bool from_tail) const;
  [[nodiscard]] bool is_of_use(Window& window, const Side& side) const;

  // exact/arrivals.cpp: what becomes of edges and vertices by that.
  void commit(std::uint32_t e, std::span<Window> fresh, double least);
  [[nodiscard]] std::span<Window> without_narrow(std::span<Window> fresh, double length) const;
  void merge_in(std::span<const Window> old, std::span<const Window> fresh, double length);
  void replace(Edge& edge, std::uint32_t first, std::uint32_t last,
               std::span<const Window> windows);
  void join_at(Edge& edge, std::uint32_t i, double length);
  void bound_edge(std::uint32_t e, double farthest);
  void let_go(std::uint32_t e);
  void relax(std::uint32_t v, double distance, const PseudoSource& pseudo_source,
             const ArrivalAtVertex& arrival);

  // exact/pseudo_sources.cpp: windows out of vertices and sources.
  void start_inside(const SurfacePoint& place, const Source& source, std::uint32_t pseudo_source);
  void bend_at(std::uint32_t v);
  void send_everywhere(std::uint32_t v, std::uint32_t pseudo_source);
  void send_beyond(std::uint32_t v, std::uint32_t pseudo_source);
  void send_from_corner(std::uint32_t corner, std::uint32_t pseudo_source, double first,
                        double last);
  void send_over(Halfedge from, std::uint32_t pseudo_source, double begin, double end, double x,
                 double y);
  void relax_along_sides(std::uint32_t corner, std::uint32_t pseudo_source);
  [[nodiscard]] bool turn(std::uint32_t corner, bool over_next, double angle);

  [[nodiscard]] bool keeps_windows_on(std::uint32_t e) const {
    return keep_windows_ && (!keeps_some_ || keep_on_edge_[e]);
  }

  [[nodiscard]] std::uint32_t nearest(std::uint32_t v) const {
    return field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
  }

  [[nodiscard]] double allowance(std::uint32_t v) const {
    return tolerance_ > 0 ? memory_.allowance[v] : 0;
  }
  [[nodiscard]] double early_by(std::uint32_t v) const;

  const Adjacency& adjacency_;
  Poll& poll_;
  Triangulation surface_;
  PropagationMemory& memory_;
  const Frames& frames_;
  std::span<Edge> edges_;
  Field& field_;
  std::span<double> distance_;  // the field's
  double max_;
  double tolerance_;
  Vectors vectors_ = best_vectors();
  bool keep_windows_;
  bool keeps_some_ = false;         // only those of these:
  std::vector<bool> keep_of_;       // by face
  std::vector<bool> keep_on_edge_;  // by edge
  // A new pseudo-source behind so many windows spares most of them. Of fewer, as on slivers
  // and flat parts, it makes more.
  std::size_t windows_for_early_source_;
  std::uint64_t propagated_ = 0;
  std::uint64_t reached_ = 0;
};

}  // namespace geodesic::exact
