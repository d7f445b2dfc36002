// A body with a head, four legs and a tail, for Fig. 8 where no scanned one is at hand.
#pragma once

#include <cstdint>

#include "core/mesh/triangle_soup.h"

namespace geodesic::report {

// y is up and the body faces -x; about 2 mesh units long. One closed surface, whose
// number of vertices grows with the square of `cells`, those of a grid along it.
[[nodiscard]] TriangleSoup generated_body(std::uint32_t cells);

}  // namespace geodesic::report
