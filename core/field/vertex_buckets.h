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
#include <span>
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
    return is_beyond(now_, key);
  }

  // Several of these, each for some of the vertices, share one order: the bucket to be taken is the
  // first of all of them (`first`), to which they all go (`go_to`), and those that have it take it.
  // So they tell and are told a bucket by its number.
  static constexpr std::uint64_t kNoBucket = std::numeric_limits<std::uint64_t>::max();
  // The first bucket that has any vertices after those that are not to be kept have left it;
  // kNoBucket when there is none. Where it is beyond the ring, its vertices were not looked at.
  template <class Keep>
  [[nodiscard]] std::uint64_t first(Keep keep) {
    for (std::uint64_t bucket = now_; in_ring_ != 0 && bucket < now_ + kRing; ++bucket) {
      std::vector<std::uint32_t>& vertices = ring_[bucket % kRing];
      if (vertices.empty()) continue;
      in_ring_ -= std::erase_if(vertices, [&](std::uint32_t vertex) { return !keep(vertex); });
      if (!vertices.empty()) return bucket;
    }
    return beyond_.empty() ? kNoBucket : beyond_.front().bucket;
  }
  // The vertices of a bucket that `first` has looked at.
  [[nodiscard]] std::span<const std::uint32_t> vertices_of(std::uint64_t bucket) const {
    return bucket < now_ + kRing ? ring_[bucket % kRing] : std::span<const std::uint32_t>();
  }
  // No bucket before this one has any vertices.
  void go_to(std::uint64_t bucket) {
    now_ = bucket;
    bring_in();
  }
  // Moves the vertices of the bucket that was gone to to the end of `taken`.
  void take_now(std::vector<std::uint32_t>& taken) {
    std::vector<std::uint32_t>& vertices = ring_[now_ % kRing];
    taken.insert(taken.end(), vertices.begin(), vertices.end());  // may throw
    in_ring_ -= vertices.size();
    vertices.clear();  // keeps its room, so that the next solve need not allocate
  }
  [[nodiscard]] bool is_beyond(std::uint64_t bucket, double key) const {
    return key < 0 || bucket > number(key);
  }

  // Moves the vertices of the first bucket that has any to the end of `taken`. Not when
  // empty.
  void take(std::vector<std::uint32_t>& taken) {
    go_to_first();
    take_now(taken);
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

  // What has come within the ring's reach.
  void bring_in() {
    while (!beyond_.empty() && beyond_.front().bucket < now_ + kRing) {
      std::pop_heap(beyond_.begin(), beyond_.end());
      const Beyond first = beyond_.back();
      beyond_.pop_back();
      push_into(first.bucket, first.vertex);
    }
  }

  void go_to_first() {
    if (in_ring_ == 0) now_ = beyond_.front().bucket;
    for (;;) {
      bring_in();
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
