// The windows that an exact field leaves on the edges: what paths and points
// inside faces are answered from. Mitchell, Mount and Papadimitriou 1987.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/large_array.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// So many windows are a step to the poll: a thousand steps take a millisecond or two.
inline constexpr std::size_t kWindowsAStep = 16;

// An interval of a halfedge's edge that one unfolded source sees straight,
// through the faces on the other side: it looks into the halfedge's own face.
//
// The frame: the edge lies on the x axis, vertex[c] of the halfedge 4f + c at 0 and
// vertex[c + 1] at the edge's length L; face f is above, the source at or below.
struct VisibleInterval {
  double begin;  // 0 <= begin < end <= L, mesh units
  double end;
  double x;                     // the unfolded source, mesh units
  double y;                     // its depth below the axis, not negative
  double offset;                // its own distance
  std::uint32_t pseudo_source;  // a vertex; kNone: the source itself
  std::uint32_t source;         // the number of the source that the way began at
};

// Windows in any order, each with the halfedge whose face it looks into. In blocks, so
// that a list of millions neither moves as it grows nor is held twice.
class VisibleIntervals {
 public:
  using Entry = std::pair<Halfedge, VisibleInterval>;

  // The budget is asked for each block; what it refuses, the computation learns when it polls
  // next. It must outlive this, or be null.
  explicit VisibleIntervals(MemoryBudget* memory = nullptr) : memory_(memory) {}

  void add(Halfedge h, const VisibleInterval& window) {
    if (blocks_.empty() || blocks_.back().size() == kBlock) add_block();
    blocks_.back().emplace_back(h, window);
    ++size_;
  }
  [[nodiscard]] std::size_t size() const { return size_; }

  // Calls `visit(entry)` for each until that returns false, …
  template <class Visit>
  void for_each(Visit visit) const {
    for (const std::vector<Entry>& block : blocks_) {
      for (const Entry& entry : block) {
        if (!visit(entry)) return;
      }
    }
  }
  // … the same from the last to the first, and gives back their memory on the way.
  template <class Visit>
  void take_backwards(Visit visit) {
    for (; !blocks_.empty(); blocks_.pop_back()) {
      const std::vector<Entry>& block = blocks_.back();
      for (auto entry = block.rbegin(); entry != block.rend(); ++entry) {
        if (!visit(*entry)) return;
      }
      size_ -= block.size();
    }
  }

  // Drops those that `keep(entry)` is false for. Of no use if the poll says to stop.
  template <class Keep>
  void keep_if(Keep keep, Poll& poll) {
    std::size_t kept = 0;
    for (const std::vector<Entry>& block : blocks_) {
      for (const Entry& entry : block) {
        if (poll.cancelled()) return;
        if (!keep(entry)) continue;
        blocks_[kept / kBlock][kept % kBlock] = entry;
        ++kept;
      }
    }
    size_ = kept;
    blocks_.resize((kept + kBlock - 1) / kBlock);
    if (!blocks_.empty()) blocks_.back().resize(kept - (blocks_.size() - 1) * kBlock);
  }

 private:
  static constexpr std::size_t kBlock = 1U << 14U;  // just below a megabyte
  // Not within `add`, which is to be short.
  __attribute__((noinline)) void add_block() {
    if (memory_ != nullptr) (void)memory_->may_take(kBlock * sizeof(Entry));
    blocks_.emplace_back().reserve(kBlock);
  }

  MemoryBudget* memory_;
  std::vector<std::vector<Entry>> blocks_;
  std::size_t size_ = 0;
};

class WindowTable {
 public:
  // Where a halfedge's windows are among all of them, of which there are no more than numbers.
  struct Part {
    std::uint32_t begin = 0;
    std::uint32_t count = 0;
  };
  static constexpr std::uint64_t kMostWindows = std::numeric_limits<std::uint32_t>::max();

  // Sorts them by halfedge and then by `begin`. Of no use if the poll says to stop. Throws
  // std::bad_alloc if there are more than kMostWindows.
  WindowTable(std::size_t face_count, VisibleIntervals windows, Poll& poll);
  // Of windows that are there already; not all of them need be in a part.
  WindowTable(std::vector<Part> parts, LargeArray<VisibleInterval> windows)
      : parts_(std::move(parts)), windows_(std::move(windows)) {}

  // The windows into a halfedge's face.
  [[nodiscard]] std::span<const VisibleInterval> into(Halfedge h) const {
    return windows_.all().subspan(parts_[h].begin, parts_[h].count);
  }
  [[nodiscard]] std::size_t size() const { return windows_.size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::vector<Part> parts_;  // 4 * face_count, by halfedge
  LargeArray<VisibleInterval> windows_;
};

// The windows of all faces of one surface that cuts a mesh up, by those faces' halfedges.
struct SurfaceWindows {
  // A source inside a face or on an edge, in one face of that surface.
  struct SourcePlace {
    std::uint32_t face;
    std::uint32_t source;           // its number
    std::array<double, 3> weights;  // barycentric
  };
  WindowTable table;
  bool is_refined;                   // of Adjacency::refined; otherwise of the mesh's own faces
  std::vector<SourcePlace> sources;  // ascending by face
  // Whether they are what was asked for, of `exact` or within a tolerance: the distances of points
  // by them are the field's, and nothing else is.
  bool are_the_answer = false;

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(SurfaceWindows) + table.bytes() + sources.capacity() * sizeof(SourcePlace);
  }
};

}  // namespace geodesic
