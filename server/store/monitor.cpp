#include "server/store/monitor.h"

#include <utility>

namespace geodesic::server {

StoreMonitor::StoreMonitor(MeshStore& store, std::chrono::milliseconds interval,
                           std::function<void()> also)
    : store_(store), also_(std::move(also)), thread_([this, interval] {
        std::unique_lock lock(mutex_);
        while (!stopping_) {
          lock.unlock();
          if (store_.check() && also_) also_();
          lock.lock();
          wake_.wait_for(lock, interval, [&] { return stopping_; });
        }
      }) {}

StoreMonitor::~StoreMonitor() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

}  // namespace geodesic::server
