// How much memory the computations hold: each in its compute slot, and all of them together.
//
// While a job runs, everything that its thread allocates with `new` counts: a method's memory, its
// result, a library's. Each allocation is checked against both bounds first. If it would exceed
// one, the computation is told to stop (core's MemoryBudget) and the allocation fails as if the
// system had no memory. The job then ends with the refusal:
//   - too_much_memory, if the job alone would hold more than one may;
//   - overloaded, if only the other jobs leave it no room: later there may be.
//
// Scratch memory that a job leaves to its slot goes on counting, and the slot's next job begins
// with it. A result that a job hands on no longer counts.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/error.h"
#include "core/base/memory_budget.h"

namespace geodesic::server {

class JobMemory;

// All slots together. Thread-safe.
class ComputeMemory {
 public:
  struct Limits {
    std::uint64_t query = 0;  // of one job that is a query; 0: as for all
    std::uint64_t all = 0;    // of all jobs together; 0: no bound
  };
  struct Stats {
    std::uint64_t bytes = 0;  // held now
    Limits limits;
    std::uint64_t refused = 0;      // jobs that wanted more than one may have
    std::uint64_t crowded_out = 0;  // jobs that had no room beside others
  };

  void set_limits(const Limits& limits);
  [[nodiscard]] Limits limits() const;
  [[nodiscard]] Stats stats() const;
  // Whether a job could have so much now.
  [[nodiscard]] bool has_room(std::uint64_t bytes) const;

 private:
  friend class JobMemory;
  std::atomic<std::int64_t> held_{0};
  std::atomic<std::uint64_t> query_limit_{0};
  std::atomic<std::uint64_t> limit_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> crowded_out_{0};
};

// Counts what the current thread allocates from its construction to its destruction, for one
// job. Used by that thread alone; one at a time.
class JobMemory {
 public:
  // `kept`: what the last job left to the slot.
  JobMemory(ComputeMemory& all, std::uint64_t kept);
  ~JobMemory();
  JobMemory(const JobMemory&) = delete;
  JobMemory& operator=(const JobMemory&) = delete;

  // The one of this thread; null where no job runs.
  [[nodiscard]] static JobMemory* here();
  // Its budget, for a Cancel; null where no job runs.
  [[nodiscard]] static MemoryBudget* budget_here();

  // Limits the job to what a query may have, besides what it found in its slot. So it does not
  // depend on earlier jobs whether a query is refused.
  void limit_to_query();

  [[nodiscard]] MemoryBudget& budget() { return budget_; }
  [[nodiscard]] const std::optional<Error>& refusal() const { return budget_.refusal(); }
  // What it would have held itself when others left no room for that; 0: it was not refused, or
  // for another reason.
  [[nodiscard]] std::uint64_t crowded_out() const;
  // The bytes that the job holds, with what was kept. What another thread has freed still counts.
  [[nodiscard]] std::uint64_t held() const;

  // From now on nothing is refused: the job only cleans up, which takes little and may not fail.
  void lift_limits() { asks_ = true; }
  // So many bytes stay with the slot when the job ends.
  void keep(std::uint64_t bytes) { kept_ = bytes; }
  [[nodiscard]] std::uint64_t kept() const { return kept_; }

  // Whether the job has freed so much since its peak that it is worth giving back to the system.
  [[nodiscard]] bool has_freed_much() const;

  // Told by `operator new` and `operator delete`. After may_allocate() follows allocated(), with
  // what was taken: 0 if the system had nothing to give.
  [[nodiscard]] bool may_allocate(std::size_t bytes);
  void allocated(std::size_t bytes);
  void freed(std::size_t bytes);

 private:
  [[nodiscard]] std::optional<Error> ask(std::uint64_t bytes);
  [[nodiscard]] bool is_within(std::uint64_t bytes) const;
  [[nodiscard]] std::uint64_t held_by_all() const;
  [[nodiscard]] bool reserve(std::size_t bytes);
  void tell();

  ComputeMemory& all_;
  const std::uint64_t found_;  // in the slot
  std::uint64_t limit_;        // 0: no bound
  bool is_query_ = false;
  std::int64_t held_;
  std::int64_t told_;  // of that, what `all_` knows
  std::int64_t most_;
  std::int64_t reserved_ = 0;  // of what is held, what is about to be allocated
  std::uint64_t kept_;
  std::uint64_t held_at_refusal_ = 0;
  std::uint64_t wanted_at_refusal_ = 0;
  bool asks_ = false;  // nothing is refused
  MemoryBudget budget_;
};

}  // namespace geodesic::server
