// A thread that checks a store every few seconds, so that a probe learns how it is
// without waiting for it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "server/store/mesh_store.h"

namespace geodesic::server {

class StoreMonitor {
 public:
  // Checks at once, then every `interval`, and calls `also`, which takes seconds at most, whenever
  // the store works. What either throws is logged, and the next round comes all the same. The store
  // must outlive the monitor.
  StoreMonitor(MeshStore& store, std::chrono::milliseconds interval,
               std::function<void()> also = {});
  ~StoreMonitor();
  StoreMonitor(const StoreMonitor&) = delete;
  StoreMonitor& operator=(const StoreMonitor&) = delete;

 private:
  void check() noexcept;

  MeshStore& store_;
  const std::function<void()> also_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace geodesic::server
