// The bound on a computation's memory. The computation asks before it takes more. Core does not
// count memory: whoever starts a computation knows what it holds, what others hold, and what there
// is.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace geodesic {

class MemoryBudget {
 public:
  // Takes the bytes that are wanted besides what is held already. Returns nothing if they may be
  // taken, or else the error that the computation ends with.
  using Ask = std::function<std::optional<Error>(std::uint64_t bytes)>;

  explicit MemoryBudget(Ask ask) : ask_(std::move(ask)) {}

  // Whether so many more bytes may be taken. After the first refusal every answer is a refusal.
  // The computing thread asks before it takes what the mesh's size does not bound, or what is
  // large.
  [[nodiscard]] bool may_take(std::uint64_t bytes) {
    if (!refusal_) refusal_ = ask_(bytes);
    return !refusal_;
  }

  // Why not, once it was refused.
  [[nodiscard]] const std::optional<Error>& refusal() const { return refusal_; }

 private:
  Ask ask_;
  std::optional<Error> refusal_;
};

}  // namespace geodesic
