// Some of the edges and vertices of a surface, and the windows on their way from and to them. All
// domains together are the surface; a propagation (propagation.h) has one, or several where threads
// help.
//
// A round has two halves. In the first, windows of the domain's edges that wait, and windows out of
// its vertices, cross the faces beyond (send_out). What comes of that is kept by whose it will be:
// lists of windows for edges, and ways to vertices. In the second, each domain takes in what all
// have for its edges and vertices (take_in). In the first half nobody sees what others do in it. In
// the second, the lists that come to one edge are taken in by an order of their own, and of the
// ways to a vertex the least is, whoever sent it. So the result does not depend on how many domains
// there are, nor on what thread works on which.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/exact/queue.h"
#include "core/exact/shared_state.h"
#include "core/exact/surface.h"
#include "core/windows/envelope.h"
#include "core/windows/propagate_lanes.h"
#include "core/windows/trim_windows.h"
#include "core/windows/window.h"
#include "core/windows/window_columns.h"
#include "core/windows/window_pool.h"

namespace geodesic::exact {

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

// Windows that come to an edge: `size` of `list` from `first` on.
struct FreshList {
  std::vector<Window>* list;
  std::size_t first;
  std::size_t size;
  double least;  // none of them is nearer anywhere
};

// The same on its way to the edge's domain.
struct HandedList {
  std::uint32_t edge;
  std::uint32_t next;   // 1 + the number of another list that comes to the same edge; 0: none
  std::uint64_t order;  // among those
  std::size_t first;    // of the sender's windows
  std::size_t size;
  double least;
};

// One that has come.
struct ComingList {
  HandedList* list;
  Window* windows;
};

// A way to a vertex, which may be shorter than those that are known.
struct HandedWay {
  std::uint32_t vertex;
  double distance;
  ArrivalAtVertex arrival;
};

// A vertex that sent out windows earlier than it was reached.
struct EarlyVertex {
  std::uint32_t vertex;
  double by;
};

// A face round a vertex, turned past from one of its two sides there to the other.
struct FanFace {
  std::uint32_t corner;
  bool from_next;  // entered over the side towards the corner's next vertex
  double begin;    // angles from the way back at which it begins and ends
  double end;
};

// Memory of one domain, kept for the next propagation. On cache lines of its own.
struct alignas(128) DomainMemory {
  WindowPool pool;  // of the edges' windows
  BucketQueue edges_waiting;
  BucketQueue vertices_waiting;
  // Each queue's, whose memory goes back there.
  std::vector<Waiting> taken_vertices;
  std::vector<Waiting> taken;
  // The next pseudo-source that the domain may make: there is room for one for each vertex that
  // waits.
  std::uint32_t next_pseudo_source = 0;
  EnteringWindows entering;
  std::vector<ListOverFace> over_faces;
  std::vector<ListOverSide> over_sides;
  // By the side: left and right.
  std::array<PropagatedWindows, 2> beyond;
  std::array<EquidistantPoints, 2> equidistant;
  std::vector<Window> fresh;  // a list that is not plain, until it is sent
  std::vector<Window> scratch;
  std::vector<FanFace> fan;

  // What a round has sent out. The first `sent` windows are in use.
  std::vector<Window> sent_windows;
  std::size_t sent = 0;
  // By whose domain it will be.
  std::vector<std::vector<HandedList>> lists_for;
  std::vector<std::vector<HandedWay>> ways_for;
  // Of edges that sent out: no place of them is farther.
  std::vector<std::pair<std::uint32_t, double>> bounds;
  std::vector<EarlyVertex> early;
  std::vector<std::uint32_t> shorter;  // vertices that a round has brought nearer
  // The lists that come to this domain, and of those to one edge.
  std::vector<ComingList> coming;
  std::vector<ComingList> to_edge;
  std::vector<ComingList> sorting;

  // Room for what the next round may need, as the last one did, so that the computing thread takes
  // it: what a thread that helps takes is asked for only after the step.
  void make_ready(std::size_t domains, Poll& poll) {
    pool.make_ready(domains, poll);
    const std::size_t wanted = 2 * sent;
    if (sent_windows.size() >= wanted || !poll.may_take(wanted * sizeof(Window))) return;
    sent_windows.resize(wanted);
  }
};

// On cache lines of its own, too.
class alignas(128) Domain {
 public:
  Domain(SharedState& state, DomainMemory& memory, std::size_t number)
      : state_(state), memory_(memory), number_(number) {}

  // Nothing waits, nothing was sent, of so many domains. Keys will be `least` or more; see
  // BucketQueue.
  void reset(std::size_t domains, double least, double width);

  // The first half of a round: windows of all edges and vertices that wait in the bucket.
  void send_out(Poll& poll);
  // The second half.
  void take_in(std::span<Domain> all, Poll& poll);

  // In place of the first half: what comes of these is handed on as in send_out.
  void begin_round(Poll& poll);
  void send_inside(const PlaceInFace& place, std::uint32_t pseudo_source);
  void send_everywhere(std::uint32_t v, std::uint32_t pseudo_source);

  // A way to one of its vertices, which is taken if it is shorter.
  void relax(std::uint32_t v, double distance, const PseudoSource& pseudo_source,
             const ArrivalAtVertex& arrival);
  // After those: vertices that have shorter ways wait to send out windows.
  void queue_vertices();

  // Windows that have crossed a face, and vertices that were reached first.
  [[nodiscard]] std::uint64_t propagated() const { return propagated_; }
  [[nodiscard]] std::uint64_t reached() const { return reached_; }

 private:
  // Of the poll's steps: few of ordinary lists, and of lists of any length one in some
  // microseconds.
  static constexpr std::size_t kWindowsAStep = 16;

  // Counts so many windows as gone through. True once the computation should stop.
  [[nodiscard]] bool cancelled_after(std::size_t windows) {
    return poll_->cancelled_after(1 + windows / kWindowsAStep);
  }
  // Whether a list may have room for so many.
  template <class T>
  [[nodiscard]] bool may_hold(const std::vector<T>& list, std::size_t count) {
    return count <= list.capacity() ||
           poll_->may_take(std::max(count, 2 * list.capacity()) * sizeof(T));
  }
  // What is refused is left out: the computation stops.
  template <class T>
  void add(std::vector<T>& list, const T& value) {
    if (may_hold(list, list.size() + 1)) list.push_back(value);
  }
  void forget_sent();

  // exact/set_out.cpp: windows set out from their edges.
  void set_out(std::uint32_t e);
  void drop_overtaken(Edge& edge);
  void join_propagated(Edge& edge);
  void load_entering(std::span<const Window> windows, Halfedge h);
  void keep_sources_on_line(std::size_t first, double length);
  void let_go(std::uint32_t e);

  // exact/cross_faces.cpp: they cross the faces beyond.
  void cross_faces();
  void cross_gathered();
  void unfold(ListOverFace& list) const;
  void find_nearest(ListOverFace& list);
  void reach_apex(const ListOverFace& list);
  void cross_to_sides(const ListOverFace& list);
  void cross_to_side(const ListOverFace& list, bool on_right, std::size_t first, std::size_t last);

  // exact/join_windows.cpp: those that cross a side become a list for its edge.
  void hand_on(const ListOverSide& list);
  [[nodiscard]] bool add_plain(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh);
  [[nodiscard]] Trimming trim_last(Window* first, Window*& last, double length);
  void add_with_care(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh);
  [[nodiscard]] Side side(Halfedge h, bool from_tail) const;
  [[nodiscard]] bool is_of_use(Window& window, const Side& side) const;
  void hand_list(std::uint32_t e, std::uint64_t order, const FreshList& fresh);
  void hand_way(std::uint32_t v, double distance, const ArrivalAtVertex& arrival);

  // exact/send_windows.cpp: windows out of vertices and sources.
  void bend_at(std::uint32_t v);
  void send_beyond(std::uint32_t v, std::uint32_t pseudo_source);
  void send_from_corner(std::uint32_t corner, std::uint32_t pseudo_source, double first,
                        double last);
  void send_over(Halfedge from, std::uint32_t pseudo_source, double begin, double end, double x,
                 double y, const std::array<double, 2>& straight);
  void hand_along_sides(std::uint32_t corner, std::uint32_t pseudo_source);
  [[nodiscard]] bool turn(std::uint32_t corner, bool over_next, double angle);

  // exact/arrivals.cpp: what becomes of edges and vertices by that.
  void take_lists(std::span<Domain> all);
  void commit(std::uint32_t e, std::span<Window> fresh, double least);
  [[nodiscard]] std::span<Window> without_narrow(std::span<Window> fresh, double length) const;
  void merge_in(std::span<const Window> old, std::span<const Window> fresh, double length);
  void replace(Edge& edge, std::uint32_t first, std::uint32_t last,
               std::span<const Window> windows);
  void join_at(Edge& edge, std::uint32_t i, double length);
  void bound_edge(std::uint32_t e, double farthest);

  [[nodiscard]] const Frames& frames() const { return state_.memory.frames; }
  [[nodiscard]] const std::vector<PseudoSource>& pseudo_sources() const {
    return state_.memory.pseudo_sources;
  }

  SharedState& state_;
  DomainMemory& memory_;
  std::size_t number_;
  Poll* poll_ = nullptr;  // of who works on the domain
  std::uint64_t propagated_ = 0;
  std::uint64_t reached_ = 0;
};

}  // namespace geodesic::exact
