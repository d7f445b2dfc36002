// Turns at something of which there may be only so much at once. Whoever waits for one waits no
// longer than they want the answer.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <semaphore>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "server/base/caller.h"
#include "server/base/service_codes.h"

namespace geodesic::server {

class Turns {
 public:
  // `refusal`: what is said to who has waited for `patience`, unless the caller is patient.
  Turns(std::size_t at_once, std::chrono::milliseconds patience, std::string refusal)
      : places_(static_cast<std::ptrdiff_t>(at_once)),
        patience_(patience),
        refusal_(std::move(refusal)) {}
  Turns(const Turns&) = delete;
  Turns& operator=(const Turns&) = delete;

  // A turn, which ends as it is destroyed, before this. Errors: cancelled, deadline; overloaded.
  [[nodiscard]] Result<std::shared_ptr<const void>> take(const Caller& caller) {
    const auto end = Caller::Clock::now() + patience_;
    while (!places_.try_acquire_for(std::chrono::milliseconds(10))) {
      if (caller()) return fail(caller.why_stopped());
      if (!caller.is_patient && Caller::Clock::now() >= end) {
        return fail(ServiceCode::overloaded, refusal_);
      }
    }
    return turn();
  }
  // Null where all are taken now.
  [[nodiscard]] std::shared_ptr<const void> take_now() {
    return places_.try_acquire() ? turn() : nullptr;
  }

 private:
  [[nodiscard]] std::shared_ptr<const void> turn() {
    return std::shared_ptr<const void>(this, [this](const void*) { places_.release(); });
  }

  std::counting_semaphore<> places_;
  const std::chrono::milliseconds patience_;
  const std::string refusal_;
};

}  // namespace geodesic::server
