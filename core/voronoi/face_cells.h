// How the cells of the nearest site divide a face.
//
// In a plane the squared distances of two points differ by a linear function of the place. So
// inside a face the squared distances, less what all of them have in common, are taken as linear,
// between their values at the corners. The cells in the face are then where each of these functions
// is least: convex polygons with straight bisectors (Edelsbrunner, Seidel, "Voronoi diagrams and
// arrangements", Discrete & Computational Geometry 1, 1986). Where sites are seen straight, over
// faces laid into a plane, that is no approximation.
//
// What lies on an edge depends on the distances at its ends alone, so that cells go on from face to
// face. Ties are broken as if site i were farther by the ith of some lengths, each of which is far
// smaller than those after it (Edelsbrunner, Mücke, "Simulation of simplicity", ACM Transactions on
// Graphics 9, 1990): the lowest of several sites is the nearest, and no more than three cells meet
// in a point.
//
// A face that a site has as a whole is all in its cell. By the distances of its corners, which are
// zero, that could be the cell of another site with the same border: the two cells then meet along
// edges of the face (border_site).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/surface/adjacency.h"
#include "core/voronoi/near_sites.h"

namespace geodesic {

// What a side of a cell's part of a face is: of the face, or against another site.
class CellSide {
 public:
  CellSide() = default;
  [[nodiscard]] static CellSide of_face(std::uint32_t corner) { return {corner, kNone}; }
  [[nodiscard]] static CellSide against(std::uint32_t site) { return {kNone, site}; }

  [[nodiscard]] bool is_of_face() const { return site_ == kNone; }
  [[nodiscard]] std::uint32_t corner() const { return corner_; }  // that the face's side starts at
  [[nodiscard]] std::uint32_t site() const { return site_; }

 private:
  CellSide(std::uint32_t corner, std::uint32_t site) : corner_(corner), site_(site) {}
  std::uint32_t corner_ = kNone;
  std::uint32_t site_ = kNone;
};

// The part of a face that is nearest to a site: side i leads from corner i to the next one, round
// the face as its own corners do.
struct CellPart {
  std::uint32_t site = kNone;
  std::vector<CellSide> sides;
  std::vector<std::array<double, 3>> corners;  // weights in the face

  // Of the face's area.
  [[nodiscard]] double share() const;
};

// Where that is in space: on an edge the same, to the last bit, from all faces there.
[[nodiscard]] Vec3 position_in_face(const Adjacency& adjacency, std::uint32_t face,
                                    const std::array<double, 3>& weights);

// Whose cell the side of a face is in that runs along an edge with this halfedge, as seen from that
// face: of an edge on which some site is at no distance. kNone where none is.
[[nodiscard]] std::uint32_t border_site(const Adjacency& adjacency, const NearSites& near,
                                        Halfedge h);

// Takes the faces one after the other.
class FaceCells {
 public:
  // Both must outlive this.
  FaceCells(const Adjacency& adjacency, const NearSites& near)
      : adjacency_(adjacency), near_(near) {}

  // Of all sites that have any, ascending; nothing where a corner is unreached. Until the next
  // call. Of k sites that are near each is cut by each, in as many steps as its part has sides so
  // far: O(k^2) where these are few, and O(k^3) where many sites lie on a circle round many. Of no
  // use if the poll says to stop.
  [[nodiscard]] std::span<const CellPart> parts_of(std::uint32_t face, Poll& poll);

  // Positive if the cells of these three, ascending, lie round the point where they meet in the
  // face of the last call as they are named; negative if the other way round.
  [[nodiscard]] double turn(const std::array<std::uint32_t, 3>& sites) const;

 private:
  struct Candidate {
    std::uint32_t site;
    std::array<double, 3> square;  // at the face's corners
  };
  using Three = std::array<const Candidate*, 3>;

  void find_candidates(const FaceRecord& face);
  void drop_hidden(Poll& poll);
  // Whether anything of the part is left.
  [[nodiscard]] bool cut(CellPart& part, const Candidate& own, const Candidate& by);
  [[nodiscard]] bool is_cut_off(const CellPart& part, std::size_t corner, const Candidate& own,
                                const Candidate& by) const;
  [[nodiscard]] std::array<double, 3> place(const CellPart& part, std::size_t corner,
                                            const Candidate& own) const;
  [[nodiscard]] const Candidate& candidate(std::uint32_t site) const;
  // The ends of a side, the lower vertex first: the same from all faces at the edge.
  [[nodiscard]] std::array<std::uint32_t, 2> ends_of(std::uint32_t side) const;

  const Adjacency& adjacency_;
  const NearSites& near_;
  const FaceRecord* face_ = nullptr;
  std::vector<Candidate> candidates_;  // ascending by site
  std::vector<CellPart> parts_;        // the first `count_` are in use
  std::size_t count_ = 0;
  std::vector<std::uint8_t> is_cut_off_;
  std::vector<Candidate> kept_;
  CellPart rest_;
};

}  // namespace geodesic
