// One job's use of the scratch memory of its compute slot. The memory is kept for the next job,
// unless it is too much to lie idle or the job did not end in order.
#pragma once

#include <cstdint>

#include "core/solve/solve_field.h"
#include "server/compute/memory.h"

namespace geodesic::server {

class ScratchUse {
 public:
  // `most_kept`: the most bytes that may lie idle; 0: any. Both others must outlive this.
  ScratchUse(SolveScratch& scratch, JobMemory& memory, std::uint64_t most_kept)
      : scratch_(scratch), memory_(memory), most_kept_(most_kept) {}
  ScratchUse(const ScratchUse&) = delete;
  ScratchUse& operator=(const ScratchUse&) = delete;
  ~ScratchUse() {
    if (is_kept_) return;
    memory_.lift_limits();
    scratch_ = SolveScratch();
    memory_.keep(0);
  }

  [[nodiscard]] SolveScratch& get() { return scratch_; }

  // The job has ended, and hands `handed_on` bytes on. All else that it holds is taken for
  // scratch memory. If some of it is not, the count is too high, until it exceeds `most_kept`: then
  // the scratch memory is freed and the count is right again.
  void done(std::uint64_t handed_on) {
    const std::uint64_t held = memory_.held();
    const std::uint64_t left = held > handed_on ? held - handed_on : 0;
    is_kept_ = !memory_.refusal() && (most_kept_ == 0 || left <= most_kept_);
    if (is_kept_) memory_.keep(left);
  }

 private:
  SolveScratch& scratch_;
  JobMemory& memory_;
  const std::uint64_t most_kept_;
  bool is_kept_ = false;
};

}  // namespace geodesic::server
