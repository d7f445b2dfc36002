// Windows on their way over the surface. Mitchell, Mount and Papadimitriou 1987,
// section 4; Surazhsky et al. 2005, section 3, with three differences:
//   - what waits in the queue is an edge, with all that has arrived there, not a
//     window, and a list of windows crosses a face at once; all edges that are about
//     as far go together, in rounds (domain.h);
//   - an edge keeps the windows of both directions in one lower envelope;
//   - of a list that crosses a face, only the window that is nearest to the far
//     corner goes on over both of the other sides: shortest paths do not cross, so
//     those to its left only go left and those to its right only go right.
//
// Every distance here is the length of a real way from a source (with a tolerance: from one of more
// sources, see below), so cutting off what is farther than another distance is always right, in
// whatever order.
//
// With a tolerance, distances are those of a field with more sources than there are: a
// vertex that is reached may become one, starting a little earlier than it was reached
// (bend_at). What its windows then outrun are the many narrow ones that came past it on
// both sides. More sources only lower a field, so it is never above the true one; and
// `allowance` says by how much it may be below: a vertex's distance and its allowance add up to
// the length of a real path. A vertex becomes a source only as far as that sum stays within
// the tolerance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/exact/domain.h"
#include "core/exact/shared_state.h"
#include "core/exact/surface.h"
#include "core/field/field.h"
#include "core/field/window_table.h"
#include "core/surface/adjacency.h"

namespace geodesic::exact {

// Memory of one propagation, kept for the next.
struct PropagationMemory {
  SharedMemory shared;
  std::vector<DomainMemory> domains;

  // What the windows of the query take that is being answered; earlier ones have no part in it.
  [[nodiscard]] std::size_t window_bytes() const;
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
  // Windows run over `surface`: the faces of the mesh or any others that cut it up, perhaps with
  // more vertices, of which the field then has all. It asks the poll where one step is long: at a
  // vertex or an edge of thousands of faces. The poll's team may help, where the mesh is large.
  Propagation(const Adjacency& adjacency, const Triangulation& surface, PropagationMemory& memory,
              Field& field, double max, double tolerance, bool keep_windows, Poll& poll);
  // Its domains refer to it.
  Propagation(const Propagation&) = delete;
  Propagation& operator=(const Propagation&) = delete;
  ~Propagation() = default;

  // Only the windows of these faces of the surface are to be kept. Before the first source.
  void keep_windows_of(std::span<const std::uint32_t> faces);

  // Behind so many windows on an edge a vertex may become a source; for
  // tests, which want it to happen on small meshes.
  void set_windows_for_early_source(std::size_t windows) {
    state_.windows_for_early_source = windows;
  }

  // Sends out a source's windows. Of faces that are not the mesh's, only one that has
  // places_on them (surface.h).
  void start(const Source& source, std::uint32_t number);

  // The next round, of all that waits in a bucket; false when there is nothing left to do.
  [[nodiscard]] bool step();

  // Vertices with a path_length() below this have their final one.
  [[nodiscard]] double final_below() const;
  // The length of the path to a vertex that is known.
  [[nodiscard]] double path_length(std::uint32_t v) const {
    return state_.distance[v] + state_.allowance(v);
  }

  // Lets distances through along edges where no window came, as a last resort
  // against rounding. True when that sent out something new. Incomplete if the poll
  // says to stop.
  [[nodiscard]] bool relax_along_edges(Poll& poll);

  // With a tolerance: makes the distances the lengths of paths, above the true ones by at
  // most that part. The last thing to ask. Incomplete if the poll says to stop.
  void raise_to_paths(Poll& poll);

  // The windows left on the edges, by the halfedges into whose faces they see: of all faces, or of
  // those that keep theirs. With a tolerance their ways are raised to paths, too. Of no use if the
  // poll says to stop.
  [[nodiscard]] WindowTable window_table(Poll& poll) const;

  // Gives the windows' memory back: the last thing to do. Not all if the poll says to stop.
  void drop_windows(Poll& poll);

  // Vertices that have a distance, though perhaps not the final one.
  [[nodiscard]] std::uint64_t reached() const;

  // Windows that have crossed a face; for tests and measurements.
  [[nodiscard]] std::uint64_t propagated() const;

 private:
  // What comes to a corner right beside a source goes on in every direction.
  void bend_at_corners_of(const PlaceInFace& place);
  [[nodiscard]] std::uint32_t add_pseudo_source(const PseudoSource& pseudo_source);
  void make_room_for_pseudo_sources();
  void forget_room_for_pseudo_sources();
  [[nodiscard]] std::span<DomainMemory> used_memory() {
    return std::span(memory_.domains).first(domains_.size());
  }
  [[nodiscard]] VisibleInterval visible_interval(const Window& w, const Edge& edge,
                                                 Halfedge h) const;
  // Does `work(domain, poll)` for each domain, by whoever is there where that is worth it. It
  // captures what Team::run says.
  template <class Work>
  void in_each_domain(bool is_worth_it, Work work);

  const Adjacency& adjacency_;
  Poll& poll_;
  PropagationMemory& memory_;
  Field& field_;
  SharedState state_;
  std::vector<Domain> domains_;
  // Windows that were sent so far, and edges and vertices that waited to send them.
  double sent_ = 0;
  double set_out_ = 0;
};

}  // namespace geodesic::exact
