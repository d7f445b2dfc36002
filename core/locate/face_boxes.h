// A bounding volume hierarchy over the faces of a mesh, without pointers.
//
// Faces follow a space-filling curve. So the boxes of a fixed number of faces in a row, and the
// boxes of a fixed number of those boxes, are a hierarchy.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/cancel.h"
#include "core/locate/unit_box.h"
#include "core/mesh/mesh.h"

namespace geodesic {

class FaceBoxes {
 public:
  // Boxes are in the frame of `unit`. Looks at each face once; of no use once the poll says to
  // stop.
  FaceBoxes(const Mesh& mesh, const UnitBox& unit, Poll& poll);

  // Shows a search the faces of all boxes that it does not turn down, those of the most promising
  // box first. The search has
  //   double least_in(const Box& box)   a bound: no face in the box has a lesser value;
  //   bool is_beaten(double least, std::size_t first_face)
  //                                     whether a box of that bound, whose faces begin with that
  //                                     one, has nothing better than what was found;
  //   void consider(std::uint32_t face)
  //   bool is_cancelled()               ends the search; asked for every box and face.
  template <class Search>
  void visit(Search& search) const {
    visit(search, levels_.size() - 1, 0);
  }

  // Memory held, without the mesh.
  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr std::size_t kFacesOfBox = 16;
  static constexpr std::size_t kBoxesOfBox = 8;

  // The recursion is as deep as there are levels: 11 for 2^32 faces.
  template <class Search>
  void visit(Search& search, std::size_t level, std::size_t block) const;

  std::size_t face_count_;
  std::vector<std::vector<Box>> levels_;  // the first has one box for each kFacesOfBox faces
};

template <class Search>
void FaceBoxes::visit(Search& search, std::size_t level, std::size_t block) const {
  if (level == 0) {
    const std::size_t end = std::min((block + 1) * kFacesOfBox, face_count_);
    for (std::size_t f = block * kFacesOfBox; f < end; ++f) {
      if (search.is_cancelled()) return;
      search.consider(static_cast<std::uint32_t>(f));
    }
    return;
  }
  const std::vector<Box>& below = levels_[level - 1];
  struct Next {
    double least;
    std::size_t block;
  };
  // The whole array is sorted, unused entries last: GCC 14 falsely warns of an overrun if only
  // the used ones are sorted.
  std::array<Next, kBoxesOfBox> order;
  order.fill({std::numeric_limits<double>::infinity(), below.size()});
  std::size_t count = 0;
  for (std::size_t i = block * kBoxesOfBox; i < std::min((block + 1) * kBoxesOfBox, below.size());
       ++i) {
    order[count++] = {search.least_in(below[i]), i};
  }
  std::sort(order.begin(), order.end(), [](const Next& a, const Next& b) {
    return a.least < b.least || (a.least == b.least && a.block < b.block);
  });
  std::size_t faces_of_block = kFacesOfBox;
  for (std::size_t l = 1; l < level; ++l) faces_of_block *= kBoxesOfBox;
  for (std::size_t i = 0; i < count; ++i) {
    if (search.is_cancelled()) return;
    if (search.is_beaten(order[i].least, order[i].block * faces_of_block)) continue;
    visit(search, level - 1, order[i].block);
  }
}

}  // namespace geodesic
