// One job's use of the scratch memory of its compute slot. The memory is kept for the next job,
// unless it is too much to lie idle or the job did not end in order.
#pragma once

#include <cstdint>

#include "core/solve/solve_field.h"
#include "server/compute/memory.h"

namespace geodesic::server {

// The scratch memory of a slot.
struct KeptScratch {
  SolveScratch memory;
  unsigned uses = 0;  // since it was empty
};

class ScratchUse {
 public:
  // `most_kept`: the most bytes that may lie idle; 0: any. Both others must outlive this.
  ScratchUse(KeptScratch& scratch, JobMemory& memory, std::uint64_t most_kept)
      : scratch_(scratch), memory_(memory), most_kept_(most_kept) {}
  ScratchUse(const ScratchUse&) = delete;
  ScratchUse& operator=(const ScratchUse&) = delete;
  ~ScratchUse() {
    if (is_kept_) return;
    memory_.lift_limits();
    scratch_ = KeptScratch();
    memory_.keep(0);
  }

  [[nodiscard]] SolveScratch& get() { return scratch_.memory; }

  // The job has ended, and hands `handed_on` bytes on. All else that it holds is taken for
  // scratch memory. If some of it is not, such as what the job left in a cache, the count is too
  // high. So after some uses the scratch memory is freed, and the count is right again.
  void done(std::uint64_t handed_on) {
    const std::uint64_t held = memory_.held();
    const std::uint64_t left = held > handed_on ? held - handed_on : 0;
    is_kept_ =
        !memory_.refusal() && ++scratch_.uses < kUses && (most_kept_ == 0 || left <= most_kept_);
    if (is_kept_) memory_.keep(left);
  }

 private:
  static constexpr unsigned kUses = 64;  // the first of so many allocates what all others use

  KeptScratch& scratch_;
  JobMemory& memory_;
  const std::uint64_t most_kept_;
  bool is_kept_ = false;
};

}  // namespace geodesic::server
