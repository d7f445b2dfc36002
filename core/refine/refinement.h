// From the faces of a refined mesh to those of the file that they are parts of, and back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

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
  // that is left has the point.
  [[nodiscard]] std::optional<FacePlace> in_piece(std::uint32_t source_face,
                                                  const Weights& bary) const;

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(*this) + pieces_.capacity() * sizeof(FacePiece) +
           by_parent_.capacity() * sizeof(std::uint32_t);
  }

 private:
  // The places in by_parent_ of a face's parts.
  [[nodiscard]] std::pair<std::size_t, std::size_t> parts_of(std::uint32_t source_face) const;

  std::vector<FacePiece> pieces_;
  std::vector<std::uint32_t> by_parent_;  // places in pieces_, by parent and then by face
};

}  // namespace geodesic
