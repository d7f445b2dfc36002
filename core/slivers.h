// Whether a surface is made of slivers.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/face_record.h"
#include "core/triangulation.h"

namespace geodesic {

// Where more than one face in four, of a sample, has a side over sixteen times as long as
// the face is high: a straight way then crosses hundreds of faces with no vertex near it.
[[nodiscard]] inline bool is_of_slivers(const Triangulation& surface) {
  constexpr double kSlender = 16;
  constexpr std::size_t kShare = 4;
  constexpr std::size_t kSample = 512;
  const std::size_t step = surface.faces.size() / kSample + 1;
  std::size_t slivers = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < surface.faces.size(); f += step, ++count) {
    const FaceRecord& face = surface.faces[f];
    const double longest2 = std::max({face.length2(0), face.length2(1), face.length2(2)});
    if (longest2 > kSlender * face.area2) ++slivers;
  }
  return kShare * slivers > count;
}

}  // namespace geodesic
