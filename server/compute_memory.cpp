#include "server/compute_memory.h"

#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

namespace geodesic::server {
namespace {

thread_local JobMemory* job_here = nullptr;

// Others learn of what a job takes, or gives back, in steps of so many bytes.
constexpr std::int64_t kStep = std::int64_t{1} << 20;
// Once refused, a job may take so much more to come to its end in order.
constexpr std::uint64_t kToEnd = std::uint64_t{32} << 20;
// Less than this is not worth a walk through the heap.
constexpr std::int64_t kMuch = std::int64_t{64} << 20;

std::uint64_t not_negative(std::int64_t bytes) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(bytes, 0));
}

}  // namespace

void ComputeMemory::set_limits(const Limits& limits) {
  query_limit_ = limits.query;
  limit_ = limits.all;
}

auto ComputeMemory::limits() const -> Limits { return {query_limit_, limit_}; }

auto ComputeMemory::stats() const -> Stats {
  return {not_negative(held_), limits(), refused_, crowded_out_};
}

JobMemory::JobMemory(ComputeMemory& all, std::uint64_t kept)
    : all_(all),
      found_(kept),
      limit_(all.limit_),
      held_(static_cast<std::int64_t>(kept)),
      told_(held_),
      most_(held_),
      kept_(kept),
      budget_([this](std::uint64_t bytes) { return ask(bytes); }) {
  job_here = this;
}

JobMemory::~JobMemory() {
  job_here = nullptr;
  // What was handed on is another's, and what is left is what was kept.
  all_.held_ += static_cast<std::int64_t>(kept_) - told_;
}

JobMemory* JobMemory::here() { return job_here; }

MemoryBudget* JobMemory::budget_here() {
  return job_here != nullptr ? &job_here->budget_ : nullptr;
}

void JobMemory::limit_to_query() {
  const std::uint64_t query = all_.query_limit_;
  if (query == 0 || (limit_ != 0 && limit_ <= query + found_)) return;
  limit_ = query + found_;
  is_query_ = true;
}

std::uint64_t JobMemory::held() const { return not_negative(held_); }

bool JobMemory::has_freed_much() const { return most_ - held_ > kMuch; }

bool JobMemory::is_within(std::uint64_t bytes) const {
  if (limit_ != 0 && held() + bytes > limit_) return false;
  const std::uint64_t all = all_.limit_;
  return all == 0 || not_negative(all_.held_ + held_ - told_) + bytes <= all;
}

std::optional<Error> JobMemory::ask(std::uint64_t bytes) {
  if (is_within(bytes)) return std::nullopt;
  const std::uint64_t wanted = held() + bytes;
  if (limit_ != 0 && wanted > limit_) {
    ++all_.refused_;
    const std::uint64_t beside = is_query_ ? found_ : 0;
    return Error{ErrorCode::too_much_memory,
                 is_query_ ? "the query takes more memory than one may: auto takes little, and "
                             "`tolerance` or a nearer `max` less"
                           : "this takes more memory than all computations may have together",
                 {},
                 limit_ - beside,
                 wanted - beside};
  }
  ++all_.crowded_out_;
  return Error{ErrorCode::overloaded,
               "other computations hold the memory that this one needs",
               {},
               all_.limit_,
               wanted};
}

bool JobMemory::may_allocate(std::size_t bytes) {
  if (is_within(bytes) || asks_) return true;
  if (refusal()) return limit_ == 0 || held() + bytes <= limit_ + kToEnd;
  asks_ = true;  // the error itself takes some
  const bool may = budget_.may_take(bytes);
  asks_ = false;
  return may;
}

void JobMemory::allocated(std::size_t bytes) {
  held_ += static_cast<std::int64_t>(bytes);
  if (held_ - told_ > kStep) tell();
}

void JobMemory::freed(std::size_t bytes) {
  held_ -= static_cast<std::int64_t>(bytes);
  if (told_ - held_ > kStep) tell();
}

void JobMemory::tell() {
  most_ = std::max(most_, held_);
  all_.held_ += held_ - told_;
  told_ = held_;
}

namespace {

// Memory as `operator new` gives it, `alignment` 0: as malloc's.
void* allocate(std::size_t bytes, std::size_t alignment) {
  JobMemory* const job = job_here;
  if (job != nullptr && !job->may_allocate(bytes)) throw std::bad_alloc();
  for (;;) {
    void* memory = nullptr;
    if (alignment == 0) {
      memory = std::malloc(std::max<std::size_t>(bytes, 1));
    } else if (::posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) != 0) {
      memory = nullptr;
    }
    if (memory != nullptr) {
      if (job != nullptr) job->allocated(::malloc_usable_size(memory));
      return memory;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void give_back(void* memory) {
  if (job_here != nullptr && memory != nullptr) job_here->freed(::malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace
}  // namespace geodesic::server

// The standard's other forms call these.
void* operator new(std::size_t bytes) { return geodesic::server::allocate(bytes, 0); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return geodesic::server::allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { geodesic::server::give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { geodesic::server::give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept {
  geodesic::server::give_back(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  geodesic::server::give_back(memory);
}
