// From the faces of a refined mesh to those of the file that they are parts of, and back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/refine/face_pieces.h"

namespace geodesic {

// A part of a source face.
struct FacePiece {
  std::uint32_t face;              // of the refined mesh
  std::uint32_t parent;            // source face
  std::array<Weights, 3> corners;  // in the parent, in the order of the face's corners
};

// A place in a face.
struct FacePlace {
  std::uint32_t face;
  Weights bary;
};

class Refinement {
 public:
  Refinement() = default;
  // Parts in any order; every face of the mesh that is not among them is a whole source face.
  explicit Refinement(std::vector<FacePiece> pieces);

  // By face.
  [[nodiscard]] const std::vector<FacePiece>& pieces() const { return pieces_; }
  // What a face is a part of; null for a whole one.
  [[nodiscard]] const FacePiece* piece(std::uint32_t face) const;
  [[nodiscard]] bool is_split(std::uint32_t source_face) const;

  // Weights in a face as those in its parent. Nothing for a whole face.
  [[nodiscard]] std::optional<Weights> in_parent(std::uint32_t face, const Weights& bary) const;
  // The part of a source face in which a point of it lies, and its weights there; on a border
  // between parts, the one of the least number. Nothing if the face is whole, or if no part of it
  // that is left has the point. Looks at those parts alone that reach as far as the point both
  // ways: few of many, but lines may make all of them so long. Of no use if the poll says to stop.
  [[nodiscard]] std::optional<FacePlace> in_piece(std::uint32_t source_face, const Weights& bary,
                                                  Poll& poll) const;

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(*this) + pieces_.capacity() * sizeof(FacePiece) +
           by_parent_.capacity() * sizeof(std::uint32_t) + extents_.capacity() * sizeof(Extent);
  }

 private:
  // How far parts reach, by the weights of their parent's second and third corner.
  struct Extent {
    std::array<double, 2> low;
    std::array<double, 2> high;
  };

  // The places in by_parent_ of a face's parts.
  [[nodiscard]] std::pair<std::size_t, std::size_t> parts_of(std::uint32_t source_face) const;
  // Puts parts of one face in the order of a tree.
  void make_tree(std::size_t first, std::size_t last);
  // Calls `visit(place in pieces_)` for those parts in a tree that reach as far as the point.
  template <class Visit>
  void each_about(std::size_t first, std::size_t last, const Weights& bary, Poll& poll,
                  const Visit& visit) const;

  std::vector<FacePiece> pieces_;
  // Places in pieces_, by parent. Those of one parent are a tree: the middle one is its root, and
  // on either side of it are those that lie to that side, of which the same holds.
  std::vector<std::uint32_t> by_parent_;
  std::vector<Extent> extents_;  // of the tree with that root, by place in by_parent_
};

}  // namespace geodesic
