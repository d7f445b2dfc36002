#include "core/wavefront/wavefront.h"

#include "core/wavefront/paper_waves.h"

namespace geodesic {

Result<Field> wavefront_field(const Adjacency& adjacency, std::span<const Source> sources,
                              const FieldLimits& limits, WavefrontScratch& scratch,
                              const Cancel& cancel) {
  return detail::waves_field<arrive>(Method::wavefront, adjacency, sources, limits, scratch,
                                     cancel);
}

}  // namespace geodesic
