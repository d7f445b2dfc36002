#include "core/solve/solve_scratch.h"

#include "core/solve/scratch_parts.h"

namespace geodesic {

SolveScratch::SolveScratch() noexcept = default;
SolveScratch::~SolveScratch() = default;
SolveScratch::SolveScratch(SolveScratch&& other) noexcept = default;
SolveScratch& SolveScratch::operator=(SolveScratch&& other) noexcept = default;

SolveScratch::Parts& SolveScratch::parts() {
  if (!parts_) parts_ = std::make_unique<Parts>();
  return *parts_;
}

}  // namespace geodesic
