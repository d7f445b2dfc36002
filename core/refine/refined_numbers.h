// A refined mesh as it is put together, and its maps in the numbers of the whole's file.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "core/mesh/triangle_soup.h"
#include "core/refine/refinement.h"

namespace geodesic {

class RefinedSoup {
 public:
  // Asks for the memory. False if the poll says to stop.
  [[nodiscard]] bool reserve(std::size_t vertices, std::size_t faces, Poll& poll);

  // `source`: the vertex's source vertex, from source_vertex_count() on for none of the file. Of
  // several with the same, the first is where that source vertex is.
  std::uint32_t add_vertex(Vec3 position, std::uint32_t source) {
    soup_.positions.push_back(position);
    sources_.push_back(source);
    return static_cast<std::uint32_t>(sources_.size() - 1);
  }
  // A whole source face.
  void add_face(const Triangle& corners, std::uint32_t source_face) {
    soup_.faces.push_back(corners);
    parents_.push_back(source_face);
  }
  // A part of one, with its corners there.
  void add_piece(const Triangle& corners, std::uint32_t source_face,
                 const std::array<Weights, 3>& in_parent) {
    pieces_.push_back({static_cast<std::uint32_t>(parents_.size()), source_face, in_parent});
    add_face(corners, source_face);
  }

  struct Built {
    Mesh mesh;
    Refinement refinement;
    std::vector<std::uint32_t> vertex_of_soup;
  };
  // `whole`: the mesh of which these are vertices, faces and parts. Errors: no_triangles (each face
  // has two corners at the same position, as parts of faces without width may), those of
  // Mesh::build.
  [[nodiscard]] Result<Built> build(const Mesh& whole, const Cancel& cancel) const;

 private:
  TriangleSoup soup_;
  std::vector<std::uint32_t> sources_;
  std::vector<std::uint32_t> parents_;
  std::vector<FacePiece> pieces_;  // their faces by number in the soup
};

}  // namespace geodesic
