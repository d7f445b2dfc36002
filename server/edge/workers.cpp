#include "server/edge/workers.h"

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <limits>
#include <system_error>
#include <utility>

namespace geodesic::server {

namespace {

// How often the clock looks. Deadlines are met within this.
constexpr std::chrono::milliseconds kTick{50};
constexpr std::chrono::milliseconds kTickWhileStopping{10};

// How long a thread stays with a connection after a reply.
constexpr int kLingerMs = 2;

// Places beyond the bound on connections, for those that were pushed out and are
// about to leave.
constexpr std::size_t kSparePlaces = 64;

// What events of no connection carry instead of a place.
constexpr std::uint64_t kOverdueData = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kEndData = kOverdueData - 1;

}  // namespace

HttpWorkers::HttpWorkers(HttpEdge& edge)
    : edge_(edge),
      place_count_(std::max<std::size_t>(1, edge.options.max_connections) + kSparePlaces),
      places_(std::make_unique<Place[]>(place_count_)),
      first_overdue_(place_count_) {
  free_.reserve(place_count_);  // who leaves must not need memory
}

HttpWorkers::~HttpWorkers() {
  stop(std::chrono::milliseconds(0));
  for (const int file : {epoll_, overdue_event_, end_event_}) {
    if (file >= 0) ::close(file);
  }
}

Result<void> HttpWorkers::start() {
  epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
  overdue_event_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK | EFD_SEMAPHORE);
  end_event_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  for (const auto& [file, data] :
       {std::pair{overdue_event_, kOverdueData}, std::pair{end_event_, kEndData}}) {
    epoll_event event{EPOLLIN, {}};
    event.data.u64 = data;
    if (epoll_ < 0 || file < 0 || ::epoll_ctl(epoll_, EPOLL_CTL_ADD, file, &event) != 0) {
      return fail(ErrorCode::internal, fmt::format("no epoll: {}", std::strerror(errno)));
    }
  }
  for (std::size_t i = 0; i < std::max<std::size_t>(1, edge_.options.io_threads); ++i) hire();
  if (threads() == 0) return fail(ErrorCode::internal, "no thread can be started");
  try {
    clock_ = std::thread([this] { watch_clock(); });
  } catch (const std::system_error& error) {
    return fail(ErrorCode::internal, fmt::format("no thread can be started: {}", error.what()));
  }
  return {};
}

// --- connections come and go

void HttpWorkers::adopt(UniqueFd socket) {
  std::size_t index = place_count_;
  {
    std::unique_lock lock(places_mutex_);
    const std::size_t bound = place_count_ - kSparePlaces;
    bool room = used_ < bound;
    if (!room) {
      lock.unlock();
      room = push_out();
      lock.lock();
    }
    if (room && !free_.empty()) {
      index = free_.back();
      free_.pop_back();
    } else if (room && high_water_ < place_count_) {
      index = high_water_++;
    }
    if (index != place_count_) ++used_;
  }
  if (index == place_count_) {
    spdlog::warn("too many connections: one is closed");
    return;
  }
  Place& place = places_[index];
  try {
    std::unique_ptr<TlsSession> tls;
    if (edge_.options.tls) tls = edge_.options.tls->open(socket.get());
    if (edge_.options.tls && !tls) throw std::bad_alloc();
    place.unwanted = false;
    place.conversation = std::make_unique<HttpConversation>(edge_, std::move(socket),
                                                            std::move(tls), place.unwanted);
  } catch (const std::exception& thrown) {
    // Whoever had the socket by then has closed it.
    spdlog::error("a connection could not be taken: {}", thrown.what());
    release(index);
    return;
  }
  if (place.conversation->is_over()) {
    release(index);
    return;
  }
  {
    const std::lock_guard lock(places_mutex_);
    place.watch = place.conversation->connection().watch();
  }
  // A worker sees to the rest. Whoever says nothing waits no longer than for a head.
  HttpConversation::Next first;
  first.what = HttpConversation::WaitsFor::readable;
  first.deadline = Clock::now() + (edge_.options.tls || edge_.options.expects_proxy_header
                                       ? edge_.options.head_timeout
                                       : edge_.keep_alive.load());
  first.idle = first.dispensable = true;
  if (!wait_in_kernel(index, first, /*first=*/true)) release(index);
}

void HttpWorkers::release(std::size_t index) {
  Place& place = places_[index];
  place.conversation.reset();  // closes the socket, which also takes it out of epoll
  const std::lock_guard lock(places_mutex_);
  place.watch.reset();
  free_.push_back(index);
  if (--used_ == 0) empty_signal_.notify_all();
}

// After this, unless it fails, the place is another thread's.
bool HttpWorkers::wait_in_kernel(std::size_t index, const HttpConversation::Next& next,
                                 bool first) {
  Place& place = places_[index];
  const int socket = place.conversation->connection().socket();
  const std::uint64_t ticket = place.next_ticket++ & kTicketMask;
  place.deadline.store(next.deadline.time_since_epoch().count(), std::memory_order_relaxed);
  place.idle.store(next.idle, std::memory_order_relaxed);
  place.dispensable.store(next.dispensable, std::memory_order_relaxed);
  place.state.store(ticket << 2 | kArming, std::memory_order_release);

  epoll_event event{EPOLLONESHOT, {}};
  event.events |= next.what == HttpConversation::WaitsFor::writable
                      ? static_cast<std::uint32_t>(EPOLLOUT)
                      : static_cast<std::uint32_t>(EPOLLIN | EPOLLRDHUP);
  event.data.u64 = static_cast<std::uint64_t>(index) << kTicketBits | ticket;
  if (::epoll_ctl(epoll_, first ? EPOLL_CTL_ADD : EPOLL_CTL_MOD, socket, &event) != 0) {
    spdlog::error("a connection cannot wait: {}", std::strerror(errno));
    place.state.store(kBusy, std::memory_order_relaxed);
    return false;
  }
  place.state.store(ticket << 2 | kParked, std::memory_order_release);
  return true;
}

bool HttpWorkers::take(Place& place, std::uint64_t state) {
  return place.state.compare_exchange_strong(state, kBusy, std::memory_order_acquire,
                                             std::memory_order_relaxed);
}

// --- workers

void HttpWorkers::work() {
  while (true) {
    epoll_event event{};
    const int count = ::epoll_wait(epoll_, &event, 1, -1);
    if (count <= 0) continue;  // a signal
    if (event.data.u64 == kEndData) return;
    if (--idle_threads_ == 0) hire();
    if (event.data.u64 == kOverdueData) {
      serve_overdue();
    } else {
      serve_event(event.data.u64);
    }
    ++idle_threads_;
  }
}

void HttpWorkers::serve_event(std::uint64_t data) {
  const auto index = static_cast<std::size_t>(data >> kTicketBits);
  const std::uint64_t ticket = data & kTicketMask;
  Place& place = places_[index];
  // The event may come while the parking thread still has its hands on the socket: it
  // is about to let go.
  while (place.state.load(std::memory_order_acquire) == (ticket << 2 | kArming)) {
    std::this_thread::yield();
  }
  if (take(place, ticket << 2 | kParked)) {
    serve(index, /*overdue=*/false);
  }
}

void HttpWorkers::serve_overdue() {
  std::uint64_t one = 0;
  if (::read(overdue_event_, &one, sizeof one) != sizeof one) return;  // another was faster
  std::size_t index = 0;
  {
    const std::lock_guard lock(overdue_mutex_);
    index = first_overdue_;
    first_overdue_ = places_[index].next_overdue;
  }
  serve(index, /*overdue=*/true);
}

void HttpWorkers::serve(std::size_t index, bool overdue) {
  HttpConversation& conversation = *places_[index].conversation;
  HttpConversation::Next next;
  do {
    next = {};
    try {
      next = conversation.advance(std::exchange(overdue, false));
    } catch (const std::exception& thrown) {  // out of memory
      spdlog::error("a connection was given up: {}", thrown.what());
    }
  } while (goes_on_at_once(conversation.connection().socket(), next));
  if (next.what == HttpConversation::WaitsFor::nothing ||
      !wait_in_kernel(index, next, /*first=*/false)) {
    release(index);
  }
}

// Whether the next request of a connection comes before parking it would have been
// worth the trouble: two more switches between threads. Waits for it only while other
// threads have nothing to do and nobody needs the place.
bool HttpWorkers::goes_on_at_once(int socket, const HttpConversation::Next& next) {
  if (next.what != HttpConversation::WaitsFor::readable || !next.idle || edge_.stopping) {
    return false;
  }
  if (idle_threads_ < 2 || 2 * connections() > place_count_ - kSparePlaces) return false;
  bool comes = false;
  if (++lingering_ <= std::max<std::size_t>(1, edge_.options.io_threads / 2)) {
    pollfd query{socket, POLLIN | POLLRDHUP, 0};
    comes = ::poll(&query, 1, kLingerMs) > 0;
  }
  --lingering_;
  return comes;
}

void HttpWorkers::hire() {
  const std::lock_guard lock(threads_mutex_);
  const std::size_t most = std::max(edge_.options.io_threads, edge_.options.max_io_threads);
  if (ending_ || threads_.size() >= std::max<std::size_t>(1, most)) return;
  ++idle_threads_;
  try {
    threads_.emplace_back([this] { work(); });
  } catch (const std::exception& error) {
    // Those that are there serve everybody, if later.
    --idle_threads_;
    spdlog::warn("no further thread for connections: {}", error.what());
  }
}

// --- the clock

void HttpWorkers::hand_over(std::size_t index) {
  {
    const std::lock_guard lock(overdue_mutex_);
    places_[index].next_overdue = place_count_;
    if (first_overdue_ == place_count_) {
      first_overdue_ = index;
    } else {
      places_[last_overdue_].next_overdue = index;
    }
    last_overdue_ = index;
  }
  const std::uint64_t one = 1;
  while (::write(overdue_event_, &one, sizeof one) != sizeof one && errno == EINTR) {
  }
}

bool HttpWorkers::push_out() {
  std::size_t used;
  {
    const std::lock_guard lock(places_mutex_);
    used = high_water_;
  }
  // Twice: what was chosen may wake up meanwhile.
  for (int attempt = 0; attempt < 2; ++attempt) {
    std::size_t chosen = used;
    std::uint64_t chosen_state = kBusy;
    auto earliest = std::numeric_limits<Clock::rep>::max();
    for (std::size_t index = 0; index < used; ++index) {
      Place& place = places_[index];
      const std::uint64_t state = place.state.load(std::memory_order_acquire);
      if ((state & 3) != kParked || !place.dispensable.load(std::memory_order_relaxed)) continue;
      const Clock::rep deadline = place.deadline.load(std::memory_order_relaxed);
      if (deadline >= earliest) continue;
      earliest = deadline;
      chosen = index;
      chosen_state = state;
    }
    if (chosen == used) return false;
    if (!take(places_[chosen], chosen_state)) continue;
    hand_over(chosen);
    return true;
  }
  return false;
}

void HttpWorkers::watch_clock() {
  std::unique_lock lock(threads_mutex_);
  while (!clock_signal_.wait_for(lock, edge_.stopping ? kTickWhileStopping : kTick,
                                 [this] { return ending_; })) {
    lock.unlock();
    std::size_t used;
    {
      const std::lock_guard places_lock(places_mutex_);
      used = high_water_;
    }
    const Clock::rep now = Clock::now().time_since_epoch().count();
    for (std::size_t index = 0; index < used; ++index) {
      Place& place = places_[index];
      const std::uint64_t state = place.state.load(std::memory_order_acquire);
      if ((state & 3) != kParked) continue;
      const bool over = place.deadline.load(std::memory_order_relaxed) <= now ||
                        place.unwanted.load(std::memory_order_relaxed) ||
                        (edge_.stopping && place.idle.load(std::memory_order_relaxed));
      // What was read belongs to the ticket if it can still be taken.
      if (over && take(place, state)) hand_over(index);
    }
    lock.lock();
  }
}

// --- the end

void HttpWorkers::cut_all() {
  const std::lock_guard lock(places_mutex_);
  for (std::size_t index = 0; index < high_water_; ++index) {
    if (places_[index].watch) places_[index].watch->cut();
  }
}

bool HttpWorkers::stop(std::chrono::milliseconds grace) {
  if (!clock_.joinable() && threads() == 0) return true;
  bool clean;
  {
    std::unique_lock lock(places_mutex_);
    const auto empty = [this] { return used_ == 0; };
    clean = empty_signal_.wait_for(lock, grace, empty);
    while (!empty()) {
      lock.unlock();
      cut_all();
      lock.lock();
      empty_signal_.wait_for(lock, std::chrono::milliseconds(20), empty);
    }
  }
  {
    const std::lock_guard lock(threads_mutex_);
    ending_ = true;
  }
  clock_signal_.notify_all();
  const std::uint64_t one = 1;
  while (::write(end_event_, &one, sizeof one) != sizeof one && errno == EINTR) {
  }
  if (clock_.joinable()) clock_.join();
  // Nobody is hired any more, so the list no longer changes.
  for (std::thread& thread : threads_) thread.join();
  const std::lock_guard lock(threads_mutex_);
  threads_.clear();
  return clean;
}

std::size_t HttpWorkers::connections() const {
  const std::lock_guard lock(places_mutex_);
  return used_;
}

std::size_t HttpWorkers::dispensable() const {
  const std::lock_guard lock(places_mutex_);
  std::size_t count = 0;
  for (std::size_t index = 0; index < high_water_; ++index) {
    const Place& place = places_[index];
    const bool waits = (place.state.load(std::memory_order_acquire) & 3) == kParked;
    count += static_cast<std::size_t>(waits && place.dispensable.load(std::memory_order_relaxed));
  }
  return count;
}

std::size_t HttpWorkers::threads() const {
  const std::lock_guard lock(threads_mutex_);
  return threads_.size();
}

}  // namespace geodesic::server
