// Distances near the sources, where ways that are traced know least of the surface.
#pragma once

#include <optional>
#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/exact/field.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// On rough surfaces (core/surface/roughness.h) and on those with many long thin faces: the
// distances up to some edges' length from the nearest of the sources, by windows; kUnreached
// beyond.
//
// There the sides of faces are as long as the way, and no vertex is near it: traced over a few
// faces, ways round a needle were up to twice as long as the shortest. An error there is in all
// distances farther on whose ways lead past it.
//
// With Bound::upper distances are longer by what rounding may have taken. Vertices so near that
// rounding is a part of their distance have none. Nothing on other surfaces, nor where windows
// become too many. Does not depend on how far a field goes. Errors: cancelled.
[[nodiscard]] Result<std::optional<Field>> field_near_sources(const Adjacency& adjacency,
                                                              std::span<const Source> sources,
                                                              Bound bound, ExactScratch& scratch,
                                                              const Cancel& cancel);

}  // namespace geodesic
