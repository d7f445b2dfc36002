// The propagation of Chen and Han's windows: where they start, how they cross a face,
// which of them are dropped. chen_han.cpp runs it in the order of its queue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/chen_han/chen_han.h"
#include "core/chen_han/window.h"
#include "core/field/field.h"
#include "core/field/window_table.h"
#include "core/surface/adjacency.h"

namespace geodesic::chen_han {

class Front {
 public:
  // All must outlive this object. field.sources, distance and nearest_source are set
  // up; the scratch memory need not be. Once the poll says to stop it is of no use.
  Front(const Adjacency& adjacency, Field& field, const FieldLimits& limits,
        ChenHanScratch& scratch, Poll& poll);

  // Sends out the windows of what a source sees within its own faces.
  void start(std::uint32_t source);

  // A vertex at which paths may bend passes on its distance, as a pseudo-source.
  void spread_from(std::uint32_t vertex);

  // Passes a window on through the face beyond it.
  void spread(Window window);

  // The windows that were passed on, without those now known to be useless.
  [[nodiscard]] std::shared_ptr<const WindowTable> take_windows();

  // Vertices that have a distance, though perhaps not the final one.
  [[nodiscard]] std::uint64_t reached() const { return reached_; }
  // Windows became too many (SeenWindows::is_overfull).
  [[nodiscard]] bool is_overfull() const { return see_all_ && scratch_.seen.is_overfull(); }

 private:
  struct Exit;
  struct IntervalOfSource;

  void mark_duplicate_faces();
  void link_participating_faces();
  void mark_faces_with_sources();
  [[nodiscard]] bool needs_seen_windows() const;
  [[nodiscard]] bool skipped(std::uint32_t face) const {
    return !scratch_.same_as.empty() && scratch_.same_as[face] != face;
  }
  // The next halfedge on the same edge whose face is not skipped; itself where there is none.
  // Only of one whose face is not.
  [[nodiscard]] Halfedge next_around(Halfedge h) const {
    return ring_.empty() ? adjacency_.ring(h) : ring_[h];
  }
  [[nodiscard]] bool bends(std::uint32_t vertex);
  [[nodiscard]] bool bends_by_its_faces(std::uint32_t vertex) const;

  void lower(std::uint32_t vertex, double distance, std::uint32_t source);
  [[nodiscard]] std::uint32_t source_of(std::uint32_t vertex) const {
    return field_.nearest_source.empty() ? 0 : field_.nearest_source[vertex];
  }
  void propagate_piece(const Window& window, const UnfoldedFace& face);
  template <class Visit>
  void for_each_piece(Halfedge side, const IntervalOfSource& from, Visit visit);
  void leave_root(Halfedge side, const UnfoldedFace& face, double x, double y, const Window& from);
  [[nodiscard]] bool enter_edge(const Exit& exit, Window& window);
  void pass(const Exit& exit, const SideInterval& at, const Window& from);
  [[nodiscard]] bool useless_in(const UnfoldedFace& face, const Window& window) const;
  void keep(const Window& window);
  void drop_useless_intervals();
  void copy_intervals_to_duplicate_faces();
  [[nodiscard]] bool useless_on(std::uint32_t at_begin, std::uint32_t at_end, double base,
                                const Window& window) const;

  const Adjacency& adjacency_;
  Field& field_;
  std::span<double> distance_;  // the field's
  const FieldLimits& limits_;
  ChenHanScratch& scratch_;
  Poll& poll_;
  std::vector<Halfedge> ring_;     // by halfedge: the next one; empty if no face is skipped
  std::uint32_t taking_part_ = 0;  // the faces that are not skipped
  VisibleIntervals intervals_;
  static constexpr std::size_t kFirstReview = 1U << 16U;
  std::size_t next_review_ = kFirstReview;
  std::uint64_t reached_ = 0;
  bool see_all_ = false;  // keep SeenWindows
  double key_ = 0;        // of what is being passed on
};

}  // namespace geodesic::chen_han
