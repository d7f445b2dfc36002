// A queue of vertices in the order of their keys but for a bucket's width: a ring of
// buckets, after Dial, "Algorithm 360: shortest-path forest with topological ordering",
// CACM 12(11), 1969, and a heap of what is beyond the ring.
//
// A front that takes a whole bucket at once has many vertices to work on together, and
// no heap to keep in order: pushing and taking a vertex cost the same on any mesh. A
// vertex whose key was lowered is pushed again and so taken twice; who takes it knows.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace geodesic {

class VertexBuckets {
 public:
  // Forgets everything. `width` is of a bucket; where that is not positive, or too little
  // to divide by, all keys share one.
  void reset(double width) {
    const double per_width = 1 / width;
    per_width_ = width > 0 && std::isfinite(per_width) ? per_width : 0;
    ring_.resize(kRing);
    if (in_ring_ != 0) {
      for (std::vector<std::uint32_t>& bucket : ring_) bucket.clear();
    }
    beyond_.clear();
    now_ = 0;
    in_ring_ = 0;
  }

  [[nodiscard]] bool empty() const { return in_ring_ == 0 && beyond_.empty(); }

  // Keys are finite and not negative. One below the bucket that was taken last counts as of that.
  // One that waits already does so by a greater key, `before`.
  void push(std::uint32_t vertex, double key,
            double before = std::numeric_limits<double>::infinity()) {
    const std::uint64_t bucket = bucket_of(key);
    const bool waits_there = std::isfinite(before) && bucket_of(before) == bucket;
    if (!waits_there) push_into(bucket, vertex);
  }
  // The same where the vertices of a bucket may be worked on before the bucket has been taken for
  // the last time: into the bucket that was taken last it comes again, though it may be there.
  void push_or_again(std::uint32_t vertex, double key, double before) {
    const std::uint64_t bucket = number(key);
    if (bucket <= now_) {
      push_into(now_, vertex);
    } else if (before == std::numeric_limits<double>::infinity() || number(before) != bucket) {
      push_into(bucket, vertex);
    }
  }
  // Back into the bucket that was taken last.
  void push_back(std::uint32_t vertex) { push_into(now_, vertex); }
  // Whether the bucket that was taken last would hold this key, and whether it has again a
  // vertex in it.
  [[nodiscard]] bool is_now(double key) const { return number(key) == now_; }
  [[nodiscard]] bool has_more_now() const { return !ring_[now_ % kRing].empty(); }
  // Whether all vertices left have keys above this one, of another bucket. Not when empty.
  [[nodiscard]] bool is_beyond(double key) {
    go_to_first();
    return key < 0 || now_ > number(key);
  }

  // Moves the vertices of the first bucket that has any to the end of `taken`. Not when
  // empty.
  void take(std::vector<std::uint32_t>& taken) {
    go_to_first();
    std::vector<std::uint32_t>& first = ring_[now_ % kRing];
    in_ring_ -= first.size();
    taken.insert(taken.end(), first.begin(), first.end());
    first.clear();  // keeps its room, so that the next solve need not allocate
  }

 private:
  static constexpr std::uint64_t kRing = 1024;
  static constexpr double kMostBuckets = 1e18;  // what is beyond shares the last one

  struct Beyond {
    std::uint64_t bucket;
    std::uint32_t vertex;
    friend bool operator<(const Beyond& a, const Beyond& b) { return a.bucket > b.bucket; }
  };

  [[nodiscard]] std::uint64_t number(double key) const {
    return static_cast<std::uint64_t>(
        static_cast<std::int64_t>(std::min(key * per_width_, kMostBuckets)));
  }
  [[nodiscard]] std::uint64_t bucket_of(double key) const { return std::max(number(key), now_); }

  void push_into(std::uint64_t bucket, std::uint32_t vertex) {
    if (bucket >= now_ + kRing) {
      beyond_.push_back({bucket, vertex});
      std::push_heap(beyond_.begin(), beyond_.end());
      return;
    }
    ring_[bucket % kRing].push_back(vertex);
    ++in_ring_;
  }

  void go_to_first() {
    if (in_ring_ == 0) now_ = beyond_.front().bucket;
    for (;;) {
      while (!beyond_.empty() && beyond_.front().bucket < now_ + kRing) {
        std::pop_heap(beyond_.begin(), beyond_.end());
        const Beyond first = beyond_.back();
        beyond_.pop_back();
        push_into(first.bucket, first.vertex);
      }
      if (!ring_[now_ % kRing].empty()) return;
      ++now_;
    }
  }

  double per_width_ = 0;
  std::vector<std::vector<std::uint32_t>> ring_;
  std::vector<Beyond> beyond_;  // a heap
  std::uint64_t now_ = 0;       // the first bucket of the ring
  std::size_t in_ring_ = 0;
};

}  // namespace geodesic
