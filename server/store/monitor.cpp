#include "server/store/monitor.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

namespace geodesic::server {

StoreMonitor::StoreMonitor(MeshStore& store, std::chrono::milliseconds interval,
                           std::function<void()> also)
    : store_(store), also_(std::move(also)), thread_([this, interval] {
        std::unique_lock lock(mutex_);
        while (!stopping_) {
          lock.unlock();
          check();
          lock.lock();
          wake_.wait_for(lock, interval, [&] { return stopping_; });
        }
      }) {}

void StoreMonitor::check() noexcept {
  try {
    if (store_.check() && also_) also_();
  } catch (const std::exception& error) {  // such as no memory, which there may be next time
    spdlog::error("store: not checked this time: {}", error.what());
  }
}

StoreMonitor::~StoreMonitor() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

}  // namespace geodesic::server
