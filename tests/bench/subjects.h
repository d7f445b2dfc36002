// The meshes that methods are compared on, and what is known of their distances
// without any code of ours.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/mesh/triangle_soup.h"

namespace geodesic::bench {

// A mesh and the question asked of it: the distances from source vertex 0.
struct Subject {
  std::string name;   // letters, digits and underscores: part of file names
  std::string title;  // for people
  TriangleSoup soup;
  // The true distance of each source vertex: a closed form, or a reference that
  // comes with the mesh. Not finite where there is none; empty when nothing is known.
  std::vector<double> known;
  // What `known` is, for people; empty with it.
  std::string known_from;
};

// `small` keeps every kind of mesh at a few hundred vertices, for tests.
enum class Scale : std::uint8_t { full, small };

// Round the diagonal, nearer to it below than above; one that narrows the way beyond;
// one that closes the way below. Figs. 6 and 7 of Tang et al. 2007: the first two
// send the shortest path from corner to corner below, the third one above.
struct Holes {
  std::uint32_t side;  // vertices along the plane
  std::vector<shapes::Hole> one, two, three;
};
[[nodiscard]] Holes holes_of_the_paper(Scale scale);

// The plane with these holes, 1 between vertices, and its closed form from vertex 0.
[[nodiscard]] Subject plane_among_holes(std::string name, std::string title, std::uint32_t side,
                                        const std::vector<shapes::Hole>& holes,
                                        shapes::Diagonal diagonal = shapes::Diagonal::rising);

// A cylinder without lids, `around` x `along` vertices: with many around and few
// along, every triangle is a sliver.
[[nodiscard]] TriangleSoup cylinder(std::uint32_t around, std::uint32_t along, double length);
[[nodiscard]] TriangleSoup stretched(TriangleSoup soup, double factor);

// Meshes from formulas, flat ones first.
[[nodiscard]] std::vector<Subject> formula_subjects(Scale scale);

// The scanned meshes of the shared folder. Says on stderr which are not there; ends
// the process when one is there and cannot be read.
[[nodiscard]] std::vector<Subject> scanned_subjects();
[[nodiscard]] std::optional<Subject> scanned_subject(const std::string& name);

// Of any format that the server reads. Ends the process when it cannot be read.
[[nodiscard]] TriangleSoup soup_of_file(const std::string& file);

}  // namespace geodesic::bench
