// One caller for whom several threads compute at once: what each of them tells of its
// part comes together here, one thread at a time, as callers are promised.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "server/base/caller.h"
#include "server/base/stage_times.h"

namespace geodesic::server {

// `caller` must outlive it.
class JointCaller {
 public:
  JointCaller(const Caller& caller, std::size_t parts) : caller_(caller), done_(parts, 0.0) {}
  JointCaller(Caller&&, std::size_t) = delete;  // it would be gone at once
  JointCaller(const JointCaller&) = delete;
  JointCaller& operator=(const JointCaller&) = delete;

  // One part under way on one thread. What it measured counts also if it is given up.
  class Part {
   public:
    Part(JointCaller& joint, std::size_t number)
        : joint_(joint), number_(number), caller_(joint.caller_) {
      if (caller_.times) caller_.times = std::make_shared<StageTimes>();
      if (caller_.progress) {
        caller_.progress = [this](double done) { joint_.tell(number_, done); };
      }
    }
    ~Part() { joint_.add(caller_.times.get()); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    // On whose behalf the part is computed.
    [[nodiscard]] const Caller& caller() const { return caller_; }
    // The part is ready. `hit` says whether what it is made of was in a cache.
    void done(bool hit) { joint_.end(number_, hit); }

   private:
    JointCaller& joint_;
    const std::size_t number_;
    Caller caller_;
  };

  // Whether all parts that were done were made of what was in a cache.
  [[nodiscard]] bool all_hit() const {
    const std::lock_guard lock(mutex_);
    return all_hit_;
  }

 private:
  void tell(std::size_t number, double done) {
    const std::lock_guard lock(mutex_);
    // A part that is begun again has been as far as it was.
    const double further = std::max(0.0, done - done_[number]);
    done_[number] += further;
    sum_ += further;
    // The sum of many small steps may be rounded up.
    const double all = std::min(sum_ / static_cast<double>(done_.size()), 1.0);
    if (caller_.progress) caller_.progress(all);
  }
  void end(std::size_t number, bool hit) {
    tell(number, 1);
    const std::lock_guard lock(mutex_);
    all_hit_ &= hit;
  }
  void add(const StageTimes* times) {
    if (!times) return;
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < kStageNames.size(); ++i) {
      caller_.times->add(static_cast<Stage>(i), times->of(static_cast<Stage>(i)));
    }
  }

  const Caller& caller_;
  mutable std::mutex mutex_;
  std::vector<double> done_;  // of each part, 0 to 1
  double sum_ = 0;            // of them
  bool all_hit_ = true;
};

}  // namespace geodesic::server
