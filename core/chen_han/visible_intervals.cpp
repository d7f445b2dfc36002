// The windows that Chen and Han's method leaves for paths and points inside faces.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/chen_han/front.h"

namespace geodesic::chen_han {

void Front::keep(const Window& window) {
  // Most windows are useless in the end; that is cheaper to find out than to store.
  if (lit_.size() > next_review_) {
    drop_useless_lit();
    next_review_ = std::max(2 * lit_.size(), kFirstReview);
  }
  lit_.add(window.into, LitWindow{window.begin, window.end, window.x, window.y, window.offset,
                                  window.root, window.source});
}

// Drops what is nowhere nearer than the ways by the corners of the lit face.
void Front::drop_useless_lit() {
  const auto useful = [&](const LitWindows::Entry& entry) {
    const LitWindow& lit = entry.second;
    Window window{};
    window.begin = lit.begin;
    window.end = lit.end;
    window.x = lit.x;
    window.y = lit.y;
    window.offset = lit.offset;
    return !useless_in(UnfoldedFace::over(adjacency_, entry.first), window);
  };
  lit_.keep_if(useful, poll_);
}

// What lights a face lights those with the same corners.
void Front::copy_lit_to_duplicate_faces() {
  std::vector<std::vector<std::uint32_t>> copies(scratch_.same_as.size());
  for (std::uint32_t f = 0; f < copies.size() && !poll_.cancelled(); ++f) {
    if (skipped(f)) copies[scratch_.same_as[f]].push_back(f);
  }
  LitWindows copied(poll_.memory());
  lit_.for_each([&](const LitWindows::Entry& entry) {
    const auto& [h, original] = entry;
    copied.add(h, original);
    const UnfoldedFace face = UnfoldedFace::over(adjacency_, h);
    for (const std::uint32_t copy : copies[face_of(h)]) {
      if (poll_.cancelled()) return false;
      const FaceRecord& other = adjacency_.face(copy);
      std::uint32_t c = 0;
      while (other.vertex[previous_corner(c)] != face.opposite) ++c;
      LitWindow window = original;
      if (other.vertex[c] != face.at_begin) {
        window.begin = face.base - original.end;
        window.end = face.base - original.begin;
        window.x = face.base - original.x;
      }
      copied.add(halfedge(copy, c), window);
    }
    return !poll_.cancelled();
  });
  lit_ = std::move(copied);
}

std::shared_ptr<const WindowTable> Front::take_windows() {
  drop_useless_lit();
  if (!scratch_.same_as.empty()) copy_lit_to_duplicate_faces();
  return std::make_shared<const WindowTable>(adjacency_.mesh().face_count(), std::move(lit_),
                                             poll_);
}

}  // namespace geodesic::chen_han
