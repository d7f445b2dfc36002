// The windows that have crossed each edge, for surfaces on which "one angle, one
// split" cannot be relied on: with edges in three faces or more, every page passes
// windows to every other, and faces without area can pass them round for ever. There a
// new window is compared with the earlier ones on its edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/chen_han/window.h"

namespace geodesic::chen_han {

class SeenWindows {
 public:
  // Forgets everything; keeps memory. Of no use if the poll says to stop, here or below.
  void reset(const Adjacency& adjacency, Poll& poll);
  // Whether the next window makes it grow, and by how many bytes.
  [[nodiscard]] bool is_full() const { return windows_.size() == windows_.capacity(); }
  [[nodiscard]] std::size_t bytes_to_grow() const { return 2 * windows_.capacity() * sizeof(Seen); }
  // A window about to cross its edge, of length `base`, is remembered and numbered.
  // When its strip is branched, it is first cut where an earlier one is nearer, or sees
  // the same from the same place. False when nothing is left.
  //
  // No face lacks a window for that: it may be the one that the earlier window came
  // through, but there the later one's way is bent back at the edge.
  [[nodiscard]] bool enter(Window& window, double base, Poll& poll);

  // Cuts it once more, by what has come since.
  [[nodiscard]] bool trim_again(Window& window, double base, Poll& poll);

  // Whether more windows were compared than on any surface but heaps of faces about the same edges:
  // there, they may double with each face that they cross.
  [[nodiscard]] bool is_overfull() const { return compared_ > most_compared_; }

 private:
  struct Seen {
    double begin;
    double end;
    double x;
    double y;
    double offset;
    std::uint32_t next;    // on the same edge
    std::uint32_t before;  // how many came to that edge before it
  };
  // Windows of all faces on an edge, in the frame of one of its halfedges.
  struct Frame {
    Halfedge edge;
    bool mirrored;
  };
  [[nodiscard]] Frame frame_of(Halfedge h) const {
    return {static_cast<Halfedge>(frames_[h] >> 1U), (frames_[h] & 1U) != 0};
  }
  [[nodiscard]] static bool cut_where_nearer(const Seen& seen, bool may_be_equal, Window& window,
                                             double base);
  // Whether the ways of `seen` are shorter everywhere in the window, or as long if they may be.
  [[nodiscard]] static bool is_no_farther(const Seen& seen, bool may_be_equal,
                                          const Window& window);
  [[nodiscard]] bool trim(Halfedge edge, Window& window, double base, Poll& poll);

  // By halfedge: twice that of its edge's frame, one more if it is mirrored. Looked for in the
  // ring each time, thousands of windows over an edge of thousands of faces would take millions.
  std::vector<std::uint64_t> frames_;
  std::vector<std::uint32_t> first_;  // by halfedge
  std::vector<Seen> windows_;
  std::uint64_t compared_ = 0;
  std::uint64_t most_compared_ = 0;
};

}  // namespace geodesic::chen_han
