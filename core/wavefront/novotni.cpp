#include "core/wavefront/novotni.h"

#include "core/wavefront/paper_waves.h"

namespace geodesic {

Result<Field> novotni_field(const Adjacency& adjacency, std::span<const Source> sources,
                            const FieldLimits& limits, WavefrontScratch& scratch,
                            const Cancel& cancel) {
  return detail::waves_field<arrive_without_cases>(Method::novotni, adjacency, sources, limits,
                                                   scratch, cancel);
}

}  // namespace geodesic
