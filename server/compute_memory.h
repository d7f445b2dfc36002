// How much memory the computations hold: each in a compute slot, and all of them together.
//
// While a job runs, all that its thread allocates with `new` counts, whoever asks for it: a
// method's memory, its result, a library's. Before each allocation both bounds are asked. Where
// one says no, the computation is told to stop (core's MemoryBudget) and the allocation fails
// as if the system had no memory; the job then ends with the refusal:
//   - too_much_memory, where the job alone would hold more than one may;
//   - overloaded, where there would be room but for the others: later there is.
//
// What a job leaves to its slot, scratch memory, counts until the slot's next job has it.
// What it hands on, its result, is from then on its receiver's.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/error.h"
#include "core/memory_budget.h"

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

  // From now on the job has no more than a query may, besides what it found in its slot: a
  // query that is refused is so whatever was asked before.
  void limit_to_query();

  [[nodiscard]] MemoryBudget& budget() { return budget_; }
  [[nodiscard]] const std::optional<Error>& refusal() const { return budget_.refusal(); }
  // What it wanted when others held that; 0: it was not refused, or for another reason.
  [[nodiscard]] std::uint64_t crowded_out() const;
  // What the job holds, with what was kept. What was freed elsewhere is in it still.
  [[nodiscard]] std::uint64_t held() const;

  // The job is done but for putting things in order, which takes little and may not fail.
  void lift_limits() { asks_ = true; }
  // So much of it stays with the slot.
  void keep(std::uint64_t bytes) { kept_ = bytes; }
  [[nodiscard]] std::uint64_t kept() const { return kept_; }

  // Whether so much was freed since the job held the most that it is worth giving back to
  // the system.
  [[nodiscard]] bool has_freed_much() const;

  // Told by `operator new` and `operator delete`.
  [[nodiscard]] bool may_allocate(std::size_t bytes);
  void allocated(std::size_t bytes);
  void freed(std::size_t bytes);

 private:
  [[nodiscard]] std::optional<Error> ask(std::uint64_t bytes);
  [[nodiscard]] bool is_within(std::uint64_t bytes) const;
  [[nodiscard]] std::uint64_t held_by_all() const;
  void tell();

  ComputeMemory& all_;
  const std::uint64_t found_;  // in the slot
  std::uint64_t limit_;        // 0: no bound
  bool is_query_ = false;
  std::int64_t held_;
  std::int64_t told_;  // of that, what `all_` knows
  std::int64_t most_;
  std::uint64_t kept_;
  std::uint64_t held_at_refusal_ = 0;
  bool asks_ = false;  // nothing is refused
  MemoryBudget budget_;
};

}  // namespace geodesic::server
