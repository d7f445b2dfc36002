// Whether ways from the sources lead across slivers, or the surface is made of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/field/straight_away.h"
#include "core/surface/adjacency.h"
#include "core/surface/triangulation.h"

namespace geodesic {

// Where more than one face in `one_in`, of a sample, is so wide across the straight way from the
// nearest source that the way crosses many faces with no vertex near it. Slivers along the
// way do no harm.
//
// Of scans stretched 8 times up to 4 % of the faces are as wide, of terrain stretched 100 times 2
// %, of saddles 5 %. On cylinders, where 6 % are, paths over 48 faces are 0.1 % too long, at 10 to
// 20 % 0.5 to 1 %, at 30 % from 7 to 14 %. Without a bound plates with holes, where 6 to 9 % are,
// are 0.1 to 0.5 % off on average, and 14 % at the most.
[[nodiscard]] inline bool leads_across_slivers(const Adjacency& adjacency,
                                               std::span<const Source> sources,
                                               std::size_t one_in) {
  constexpr double kWide = 12;  // of a width's square over the area: 2.3 where sides are equal
  constexpr std::size_t kSample = 2048;
  if (sources.empty()) return false;
  const StraightAway straight(adjacency.mesh(), sources);
  const auto faces = adjacency.delaunay().faces;
  const std::size_t step = faces.size() / kSample + 1;
  std::size_t wide = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < faces.size(); f += step, ++count) {
    const auto extents = straight.extents_across(faces[f].vertex);
    if (!extents) continue;
    const double width = *std::max_element(extents->begin(), extents->end());
    if (width * width > 0.5 * kWide * faces[f].area2) ++wide;
  }
  return one_in * wide > count;
}

// Where more than one face in ten, of a sample, is lower than that part of its longest side.
[[nodiscard]] inline bool is_of_slivers(const Triangulation& surface, double low_part = 0.1) {
  constexpr std::size_t kShare = 10;
  constexpr std::size_t kSample = 512;
  const std::size_t step = surface.faces.size() / kSample + 1;
  std::size_t low = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < surface.faces.size(); f += step, ++count) {
    const FaceRecord& face = surface.faces[f];
    if (!(face.area2 > low_part * face.longest2())) ++low;
  }
  return kShare * low > count;
}

}  // namespace geodesic
