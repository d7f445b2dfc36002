// The windows that Chen and Han's method leaves for paths and points inside faces.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/chen_han/front.h"

namespace geodesic::chen_han {

void Front::keep(const Window& window) {
  // Most windows are useless in the end; that is cheaper to find out than to store.
  if (intervals_.size() > next_review_) {
    drop_useless_intervals();
    next_review_ = std::max(2 * intervals_.size(), kFirstReview);
  }
  intervals_.add(window.into, VisibleInterval{window.begin, window.end, window.x, window.y,
                                              window.offset, window.pseudo_source, window.source});
}

// Drops what is nowhere nearer than the ways by the corners of the face beyond.
void Front::drop_useless_intervals() {
  const auto useful = [&](const VisibleIntervals::Entry& entry) {
    const VisibleInterval& interval = entry.second;
    Window window{};
    window.begin = interval.begin;
    window.end = interval.end;
    window.x = interval.x;
    window.y = interval.y;
    window.offset = interval.offset;
    return !useless_in(UnfoldedFace::over(adjacency_, entry.first), window);
  };
  intervals_.keep_if(useful, poll_);
}

// A window into a face is one into those with the same corners.
void Front::copy_intervals_to_duplicate_faces() {
  std::vector<std::vector<std::uint32_t>> copies(scratch_.same_as.size());
  for (std::uint32_t f = 0; f < copies.size() && !poll_.cancelled(); ++f) {
    if (skipped(f)) copies[scratch_.same_as[f]].push_back(f);
  }
  VisibleIntervals copied(poll_.memory());
  intervals_.for_each([&](const VisibleIntervals::Entry& entry) {
    const auto& [h, original] = entry;
    copied.add(h, original);
    const UnfoldedFace face = UnfoldedFace::over(adjacency_, h);
    for (const std::uint32_t copy : copies[face_of(h)]) {
      if (poll_.cancelled()) return false;
      const FaceRecord& other = adjacency_.face(copy);
      std::uint32_t c = 0;
      while (other.vertex[previous_corner(c)] != face.opposite) ++c;
      VisibleInterval window = original;
      if (other.vertex[c] != face.at_begin) {
        window.begin = face.base - original.end;
        window.end = face.base - original.begin;
        window.x = face.base - original.x;
      }
      copied.add(halfedge(copy, c), window);
    }
    return !poll_.cancelled();
  });
  intervals_ = std::move(copied);
}

std::shared_ptr<const WindowTable> Front::take_windows() {
  drop_useless_intervals();
  if (!scratch_.same_as.empty()) copy_intervals_to_duplicate_faces();
  return std::make_shared<const WindowTable>(adjacency_.mesh().face_count(), std::move(intervals_),
                                             poll_);
}

}  // namespace geodesic::chen_han
