// The memory that methods work in.
#pragma once

#include <memory>

namespace geodesic {

// Kept from one computation to the next on the same thread, so that a later one allocates little.
// Serves one computation at a time, and holds nothing before the first.
class SolveScratch {
 public:
  SolveScratch() noexcept;
  ~SolveScratch();
  SolveScratch(SolveScratch&& other) noexcept;
  SolveScratch& operator=(SolveScratch&& other) noexcept;

  struct Parts;  // scratch_parts.h: one for each method, for the engine itself
  [[nodiscard]] Parts& parts();

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace geodesic
