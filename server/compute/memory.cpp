#include "server/compute/memory.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "server/base/service_codes.h"

namespace geodesic::server {
namespace {

thread_local JobMemory* job_here = nullptr;

// A job adds what it takes or gives back to the sum of all jobs in steps of so many bytes.
constexpr std::int64_t kStep = std::int64_t{1} << 20;
// A refused job may exceed its limit by so many bytes, to end in order.
constexpr std::uint64_t kToEnd = std::uint64_t{32} << 20;
// What is smaller than that in bytes is counted once it is there; so is what no system has, for
// which sums would overflow.
constexpr std::size_t kCountedFirst = std::size_t{1} << 20;
constexpr std::size_t kNeverThere = std::size_t{1} << 60;
// Returning less than this to the system is not worth trim_heaps().
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

bool ComputeMemory::has_room(std::uint64_t bytes) const {
  const std::uint64_t all = limit_;
  return all == 0 || not_negative(held_) + bytes <= all;
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
  // What was handed on no longer counts; what was kept still does.
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

std::uint64_t JobMemory::crowded_out() const {
  return refusal() && refusal()->code == ServiceCode::overloaded ? wanted_at_refusal_ : 0;
}

std::uint64_t JobMemory::held() const { return not_negative(held_); }

bool JobMemory::has_freed_much() const { return most_ - held_ > kMuch; }

bool JobMemory::is_within(std::uint64_t bytes) const {
  if (limit_ != 0 && held() + bytes > limit_) return false;
  const std::uint64_t all = all_.limit_;
  return all == 0 || held_by_all() + bytes <= all;
}

std::uint64_t JobMemory::held_by_all() const { return not_negative(all_.held_ + held_ - told_); }

std::optional<Error> JobMemory::ask(std::uint64_t bytes) {
  if (is_within(bytes)) return std::nullopt;
  const std::uint64_t wanted = held() + bytes;
  held_at_refusal_ = held();
  wanted_at_refusal_ = wanted;
  if (limit_ != 0 && wanted > limit_) {
    ++all_.refused_;
    const std::uint64_t beside = is_query_ ? found_ : 0;
    return Error{ServiceCode::too_much_memory,
                 is_query_ ? "the query takes more memory than one may: auto without a "
                             "`tolerance` takes little, and a nearer `max` less"
                           : "this takes more memory than all computations may have together",
                 {},
                 limit_ - beside,
                 wanted - beside};
  }
  ++all_.crowded_out_;
  return Error{ServiceCode::overloaded,
               "other computations hold the memory that this one needs",
               {},
               all_.limit_,
               held_by_all() + bytes};
}

bool JobMemory::may_allocate(std::size_t bytes) {
  const bool is_counted_first = bytes >= kCountedFirst && bytes < kNeverThere;
  while (!asks_ && !(is_counted_first ? reserve(bytes) : is_within(bytes))) {
    if (refusal()) return held() + bytes <= held_at_refusal_ + kToEnd;
    asks_ = true;  // making the error allocates too
    const bool may = budget_.may_take(bytes);
    asks_ = false;
    if (!may) return false;
    // Another job has just given back what was missing.
  }
  return true;
}

// Jobs that ask at the same moment share what room there is: the sum of all grows with the answer.
bool JobMemory::reserve(std::size_t bytes) {
  if (limit_ != 0 && held() + bytes > limit_) return false;
  const std::int64_t then = held_ + static_cast<std::int64_t>(bytes);
  const std::uint64_t most = all_.limit_;
  std::int64_t all = all_.held_;
  do {
    if (most != 0 && not_negative(all + then - told_) > most) return false;
  } while (!all_.held_.compare_exchange_weak(all, all + then - told_));
  held_ = told_ = then;
  most_ = std::max(most_, held_);
  reserved_ = static_cast<std::int64_t>(bytes);
  return true;
}

void JobMemory::allocated(std::size_t bytes) {
  held_ += static_cast<std::int64_t>(bytes) - reserved_;
  reserved_ = 0;
  if (std::abs(held_ - told_) > kStep) tell();
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

}  // namespace geodesic::server
