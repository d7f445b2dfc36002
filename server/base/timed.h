// Adds the time until its end to a stage of its caller's request.
#pragma once

#include "server/base/caller.h"
#include "server/base/stage_times.h"

namespace geodesic::server {

class Timed {
 public:
  using Clock = Caller::Clock;

  // `caller` must outlive it.
  Timed(const Caller& caller, Stage stage) : caller_(caller), stage_(stage) {}
  ~Timed() {
    if (caller_.times) caller_.times->add(stage_, so_far());
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

  [[nodiscard]] StageTimes::Duration so_far() const { return Clock::now() - begin_; }

 private:
  const Caller& caller_;
  const Stage stage_;
  const Clock::time_point begin_ = Clock::now();
};

}  // namespace geodesic::server
