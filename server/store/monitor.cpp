#include "server/store/monitor.h"

namespace geodesic::server {

StoreMonitor::StoreMonitor(MeshStore& store, std::chrono::milliseconds interval)
    : store_(store), thread_([this, interval] {
        std::unique_lock lock(mutex_);
        while (!stopping_) {
          lock.unlock();
          (void)store_.check();
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
