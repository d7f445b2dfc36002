// What waits to be passed on, in a ring of buckets by distance. Within a bucket
// all goes together: exact propagation corrects what it did too early, so an
// order that is nearly right will do, and costs no heap.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace geodesic::exact {

struct Waiting {
  enum class What : std::uint32_t { edge, vertex, bounded_edge };
  double key;
  std::uint32_t number;
  What what;
};

class BucketQueue {
 public:
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  // Empties the queue. Keys will be `least` or more; buckets are `width` wide.
  void reset(double least, double width) {
    for (std::vector<Waiting>& bucket : ring_) leave(bucket);
    occupied_.fill(0);
    later_.clear();
    least_later_ = kNever;
    least_ = least;
    per_width_ = 1 / width;
    now_ = 0;
    width_ = width;
  }

  void push(const Waiting& waiting) {
    const std::uint64_t bucket = std::max(bucket_of(waiting.key), now_);
    if (bucket - now_ >= kBuckets) {
      later_.push_back(waiting);
      least_later_ = std::min(least_later_, bucket);
      return;
    }
    put(waiting, bucket);
  }

  // The first bucket that holds something, or may; kNever when none does.
  [[nodiscard]] std::uint64_t next() const { return std::min(next_occupied(), least_later_); }
  // To that one, or one before it.
  void go_to(std::uint64_t bucket) {
    now_ = bucket;
    if (now_ == least_later_) bring_in_later();
  }
  [[nodiscard]] std::size_t count_now() const { return ring_[now_ % kBuckets].size(); }
  // All that waits in the bucket, in the order in which it came. What comes from now on waits for
  // the next time.
  void take(std::vector<Waiting>& taken) {
    std::vector<Waiting>& bucket = ring_[now_ % kBuckets];
    taken.clear();
    if (bucket.empty()) return;
    std::swap(taken, bucket);
    leave(bucket);
    occupied_[now_ % kBuckets / 64] &= ~(std::uint64_t{1} << (now_ % 64));
  }

  // No key that comes from now on is less, nor anything that follows from it.
  [[nodiscard]] double now() const {
    return now_ == 0 ? least_ : least_ + (static_cast<double>(now_) - 1e-6) * width_;
  }

 private:
  static constexpr std::uint64_t kBuckets = 1024;
  static constexpr std::uint64_t kLast = std::uint64_t{1} << 52U;

  [[nodiscard]] std::uint64_t bucket_of(double key) const {
    const double bucket = (key - least_) * per_width_;
    if (!(bucket > 0)) return 0;
    return bucket < static_cast<double>(kLast) ? static_cast<std::uint64_t>(bucket) : kLast;
  }

  // A bucket's memory goes to the next one that is in need: few are in use at a time, and that
  // memory is still in the caches.
  void leave(std::vector<Waiting>& bucket) {
    if (bucket.capacity() == 0) return;
    bucket.clear();
    spare_.push_back(std::move(bucket));
    bucket = {};
  }

  void put(const Waiting& waiting, std::uint64_t bucket) {
    const std::uint64_t place = bucket % kBuckets;
    if (ring_[place].capacity() == 0 && !spare_.empty()) {
      ring_[place] = std::move(spare_.back());
      spare_.pop_back();
    }
    ring_[place].push_back(waiting);
    occupied_[place / 64] |= std::uint64_t{1} << (place % 64);
  }

  [[nodiscard]] std::uint64_t next_occupied() const {
    const std::uint64_t start = now_ % kBuckets;
    for (std::uint64_t i = 0; i <= kWords; ++i) {
      const std::uint64_t word = (start / 64 + i) % kWords;
      std::uint64_t bits = occupied_[word];
      if (i == 0) bits &= ~std::uint64_t{0} << (start % 64);
      if (i == kWords) bits &= ~(~std::uint64_t{0} << (start % 64));
      if (bits == 0) continue;
      const std::uint64_t place = 64 * word + static_cast<std::uint64_t>(std::countr_zero(bits));
      return now_ + (place + kBuckets - start) % kBuckets;
    }
    return kNever;
  }

  // What has come within the ring's reach.
  void bring_in_later() {
    least_later_ = kNever;
    std::size_t kept = 0;
    for (const Waiting& waiting : later_) {
      const std::uint64_t bucket = std::max(bucket_of(waiting.key), now_);
      if (bucket - now_ >= kBuckets) {
        least_later_ = std::min(least_later_, bucket);
        later_[kept++] = waiting;
      } else {
        put(waiting, bucket);
      }
    }
    later_.resize(kept);
  }

  static constexpr std::uint64_t kWords = kBuckets / 64;

  std::array<std::vector<Waiting>, kBuckets> ring_;
  std::array<std::uint64_t, kWords> occupied_{};
  std::vector<std::vector<Waiting>> spare_;  // memory of buckets that are done
  std::vector<Waiting> later_;               // beyond the ring's reach
  std::uint64_t least_later_ = kNever;       // the first bucket that one of them belongs in
  double least_ = 0;
  double width_ = 1;
  double per_width_ = 1;
  std::uint64_t now_ = 0;
};

}  // namespace geodesic::exact
