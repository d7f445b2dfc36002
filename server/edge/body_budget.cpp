#include "server/edge/body_budget.h"

#include <algorithm>
#include <cmath>

namespace geodesic::server {

namespace {

using Seconds = std::chrono::duration<double>;

// A client holds much if it holds at least what the greediest client holds over this.
constexpr std::uint64_t kMuch = 4;
// A body goes for another one of the same client only if it is more than so many times slower.
constexpr double kMuchSlower = 4;
// A younger body counts as this old: its first moment says little about its rate.
constexpr double kLeastAge = 0.25;  // seconds

}  // namespace

BodyBudget::BodyBudget(std::uint64_t most, std::chrono::milliseconds memory)
    : most_(most), memory_(std::max(Seconds(memory).count(), kLeastAge)) {}

// Bytes a second: of the last `memory_` seconds, or of its life if that is shorter.
double BodyBudget::rate(const Part& part, Clock::time_point now) const {
  const double age = std::max(Seconds(now - part.begun_).count(), kLeastAge);
  const double silent = Seconds(now - part.last_).count();
  return part.recent_ * std::exp(-silent / memory_) / (memory_ * (1 - std::exp(-age / memory_)));
}

BodyBudget::Part* BodyBudget::slowest(Clock::time_point now) {
  std::uint64_t greediest = 0;
  for (const Part* part : received_) greediest = std::max(greediest, of_client_[part->client_]);
  Part* slowest = nullptr;
  double least = 0;
  for (Part* part : received_) {
    if (part->bytes_ == 0 || of_client_[part->client_] < greediest / kMuch) continue;
    const double rate = this->rate(*part, now);
    if (slowest != nullptr && rate >= least) continue;
    slowest = part;
    least = rate;
  }
  return slowest;
}

void BodyBudget::forget(Part& part) {
  total_ -= part.bytes_;
  const auto found = of_client_.find(part.client_);
  if (found != of_client_.end() && (found->second -= part.bytes_) == 0) of_client_.erase(found);
  part.bytes_ = 0;
}

void BodyBudget::leave(Part& part) {
  if (part.is_received_) received_.erase(part.place_);
  part.is_received_ = false;
}

void BodyBudget::Part::begin(const std::string& client, Clock::time_point now) {
  const std::lock_guard lock(budget_.mutex_);
  budget_.received_.push_front(this);
  place_ = budget_.received_.begin();
  is_received_ = is_there_ = true;
  is_evicted_ = false;
  unwanted_ = false;
  client_ = client;
  begun_ = last_ = now;
  recent_ = 0;
}

bool BodyBudget::Part::hold(std::uint64_t bytes, Clock::time_point now) {
  const std::lock_guard lock(budget_.mutex_);
  if (is_evicted_) return false;
  const std::uint64_t more = bytes - bytes_;
  if (more == 0) return true;
  budget_.of_client_[client_] += more;
  budget_.total_ += more;
  bytes_ = bytes;
  recent_ = recent_ * std::exp(-Seconds(now - last_).count() / budget_.memory_) +
            static_cast<double>(more);
  last_ = now;
  while (budget_.most_ != 0 && budget_.total_ > budget_.most_) {
    Part* const part = budget_.slowest(now);
    if (part == nullptr || part == this) return false;
    if (part->client_ == client_ &&
        budget_.rate(*part, now) * kMuchSlower > budget_.rate(*this, now)) {
      return false;
    }
    budget_.forget(*part);
    budget_.leave(*part);
    part->is_evicted_ = true;
    part->unwanted_ = true;
  }
  return true;
}

bool BodyBudget::Part::complete() {
  const std::lock_guard lock(budget_.mutex_);
  budget_.leave(*this);
  return !is_evicted_;
}

void BodyBudget::Part::release() {
  if (!is_there_) return;
  const std::lock_guard lock(budget_.mutex_);
  budget_.leave(*this);
  budget_.forget(*this);
  is_there_ = is_evicted_ = false;
  unwanted_ = false;
}

}  // namespace geodesic::server
