// The threads that serve a listener's connections, and the place where connections
// wait for them. A connection whose peer must act first waits in the kernel's epoll
// and holds no thread; all threads that have nothing to do wait there too, and each
// event wakes one. When the last of them has become busy another is started, so
// that requests which wait (for a compute slot, say) never keep a new one waiting,
// up to a bound. Between requests that follow each other closely, a thread stays with
// its connection for a moment, as long as others are free.
//
// One more thread, the clock, looks for connections whose time is over.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "server/base/unique_fd.h"
#include "server/edge/conversation.h"

namespace geodesic::server {

class HttpWorkers {
 public:
  // `edge.options` says how many threads and connections. `edge` must outlive it.
  explicit HttpWorkers(HttpEdge& edge);
  ~HttpWorkers();  // stops without grace
  HttpWorkers(const HttpWorkers&) = delete;
  HttpWorkers& operator=(const HttpWorkers&) = delete;

  // Starts the threads. Fails with `internal` if the system refuses. To be called once.
  [[nodiscard]] Result<void> start();

  // Serves an accepted socket. Where all places are taken, a connection that
  // idles (or has not managed to send a request) makes room; if there is none, the
  // new one is closed.
  void adopt(UniqueFd socket);

  // With `edge.stopping` set and no more `adopt`: ends idle connections, waits up to
  // `grace` for the others, cuts what is left and ends the threads. True if nothing
  // had to be cut. To be called once, not from a worker.
  bool stop(std::chrono::milliseconds grace);

  [[nodiscard]] std::size_t connections() const;
  // Those that could be pushed out now.
  [[nodiscard]] std::size_t dispensable() const;
  [[nodiscard]] std::size_t threads() const;

 private:
  using Clock = HttpConversation::Clock;

  // A place for a connection. Places are never freed, only used again, so a late
  // event can do no harm: it names the ticket of the wait it belongs to, and only
  // who turns that ticket to `busy` owns the place. The clock takes only what is
  // `parked`: while `arming`, the parking thread still has its hands on the socket.
  struct Place {
    std::atomic<std::uint64_t> state{kBusy};  // busy, or a ticket and what it is about
    std::atomic<Clock::rep> deadline{0};
    std::atomic<bool> idle{false};
    std::atomic<bool> dispensable{false};
    std::atomic<bool> unwanted{false};               // its body is to go, for others'
    std::size_t next_overdue = 0;                    // guarded by overdue_mutex_
    std::uint64_t next_ticket = 1;                   // the owner's
    std::unique_ptr<HttpConversation> conversation;  // the owner's
    std::shared_ptr<PeerWatch> watch;                // guarded by places_mutex_; null: free
  };
  static constexpr std::uint64_t kBusy = 0;
  static constexpr std::uint64_t kArming = 1;
  static constexpr std::uint64_t kParked = 2;
  // Events carry the place's number above the ticket.
  static constexpr int kTicketBits = 40;
  static constexpr std::uint64_t kTicketMask = (std::uint64_t{1} << kTicketBits) - 1;

  [[nodiscard]] bool wait_in_kernel(std::size_t index, const HttpConversation::Next& next,
                                    bool first);
  void work();
  void serve(std::size_t index, bool overdue);
  [[nodiscard]] bool goes_on_at_once(int socket, const HttpConversation::Next& next);
  void serve_event(std::uint64_t data);
  void serve_overdue();
  void release(std::size_t index);
  void hire();  // starts a thread, if there may be more
  // Makes a parked connection the caller's, if it still waits as `state` says.
  [[nodiscard]] bool take(Place& place, std::uint64_t state);
  void hand_over(std::size_t index);  // what was taken, to a worker, as overdue
  [[nodiscard]] bool push_out();
  void watch_clock();
  void cut_all();

  HttpEdge& edge_;
  const std::size_t place_count_;
  const std::unique_ptr<Place[]> places_;
  int epoll_ = -1;
  int overdue_event_ = -1;  // counts overdue_
  int end_event_ = -1;      // stays readable once the threads are to end

  mutable std::mutex places_mutex_;
  std::condition_variable empty_signal_;
  std::vector<std::size_t> free_;  // guarded, like the next two
  std::size_t high_water_ = 0;     // places from here on were never used
  std::size_t used_ = 0;

  std::mutex overdue_mutex_;
  // A line of places, through `next_overdue`: it takes no memory, which may be what lacks.
  std::size_t first_overdue_ = 0;  // place_count_: there is none
  std::size_t last_overdue_ = 0;

  mutable std::mutex threads_mutex_;
  std::vector<std::thread> threads_;
  std::atomic<std::size_t> idle_threads_{0};
  std::atomic<std::size_t> lingering_{0};  // threads that wait for one connection
  std::thread clock_;
  std::condition_variable clock_signal_;
  bool ending_ = false;  // guarded by threads_mutex_
};

}  // namespace geodesic::server
