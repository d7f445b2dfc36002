// How much memory a computation may take, asked before it grows. Core does not count: whoever
// starts a computation knows what it holds by now, what others hold, and what there is.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "core/error.h"

namespace geodesic {

class MemoryBudget {
 public:
  // Given the bytes that are wanted besides what is held already: nothing if they may be taken,
  // or the error that the computation ends with.
  using Ask = std::function<std::optional<Error>(std::uint64_t bytes)>;

  explicit MemoryBudget(Ask ask) : ask_(std::move(ask)) {}

  // Whether so many bytes more may be taken; false for ever after the first time that it is.
  // Asked by the computing thread before it takes what the mesh's size does not bound, or
  // what is large.
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
