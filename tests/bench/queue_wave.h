// The wavefront of one source over all vertices, with a queue of choice: the
// loop of core/wavefront/wavefront.cpp without targets, limits or cancelling, so that two
// queues are compared on nothing but the queue.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/wavefront/kernel.h"

namespace geodesic::bench {

template <class Queue>
class QueueWave {
 public:
  explicit QueueWave(const Adjacency& adjacency) : adjacency_(adjacency) {}

  void run(const Source& source) {
    const std::size_t vertex_count = adjacency_.mesh().vertex_count();
    distance_.assign(vertex_count, kUnreached);
    parents_.assign(vertex_count, {});
    queue_.reset(vertex_count);
    detail::Wavefront<Queue> front(adjacency_, queue_, distance_, parents_);
    for (const std::uint32_t v : front.start(source, 0)) front.spread_from(v);
    while (!queue_.empty()) front.spread_from(queue_.pop().vertex);
  }
  [[nodiscard]] std::span<const double> distance() const { return distance_; }

 private:
  const Adjacency& adjacency_;
  Queue queue_;
  std::vector<double> distance_;
  std::vector<Parents> parents_;
};

}  // namespace geodesic::bench
