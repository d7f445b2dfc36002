// On whose behalf work is done: what a queue needs to be fair, and a computation
// to stop early. Made by the HTTP edge, passed down by reference.
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "server/base/service_codes.h"
#include "server/base/stage_times.h"

namespace geodesic::server {

struct Caller {
  using Clock = std::chrono::steady_clock;

  Caller() = default;
  // Nobody in particular, known only by whether it is still there.
  template <class Gone>
  requires(!std::same_as<std::remove_cvref_t<Gone>, Caller> &&
           std::is_invocable_r_v<bool, const std::remove_cvref_t<Gone>&>)
      // NOLINTNEXTLINE(*-explicit-constructor, *-forwarding-reference-overload): a lambda is one
      Caller(Gone&& is_gone)
      : gone(std::forward<Gone>(is_gone)) {}

  // What it asks, to be named in the log.
  struct Asked {
    std::string id;  // X-Request-Id
    std::string method;
    std::string target;  // as sent
  };

  std::string client;                  // equal for what shares one turn in a queue; "": anonymous
  std::function<bool()> gone;          // may be empty: never. Must not throw
  std::shared_ptr<StageTimes> times;   // where the time goes; may be null
  std::shared_ptr<const Asked> asked;  // may be null
  std::optional<Clock::time_point> deadline;  // after it, nobody wants the answer
  // Told, by whichever thread computes, which part is done, 0 to 1; may be empty. Who
  // computes in several steps need not take care that it never falls.
  std::function<void(double)> progress;
  // Counts so many bytes as held for it until what is returned is gone, for what it holds beyond
  // the compute slot that made it; may be empty: nobody counts. Called by one thread at a time.
  // Errors: too_much_memory, overloaded, too_many_requests.
  std::function<Result<std::shared_ptr<const void>>(std::uint64_t bytes)> reserve;
  bool is_patient = false;  // waits for its turn however long that takes
  // What it asks for ends a request that has had its turn: it does not wait for another one.
  bool is_finishing = false;

  [[nodiscard]] bool deadline_over() const { return deadline && Clock::now() >= *deadline; }
  // What it stopped by, once it has: its deadline, or its client's leaving.
  [[nodiscard]] Error why_stopped() const {
    if (deadline_over()) {
      return {ServiceCode::deadline, "the request's deadline has passed", {}, {}, {}};
    }
    return {ErrorCode::cancelled, "the client is gone", {}, {}, {}};
  }
  // The same caller for one of several computations, which is the part from `begin`
  // to `end` of them all.
  [[nodiscard]] Caller part(double begin, double end) const {
    Caller part = *this;
    if (progress) {
      part.progress = [whole = progress, begin, end](double done) {
        whole(std::min(begin + (end - begin) * done, end));
      };
    }
    return part;
  }
  // The same caller for the rest of a request, once what takes long is done.
  [[nodiscard]] Caller finishing() const {
    Caller rest = *this;
    rest.is_finishing = true;
    return rest;
  }
  // Whether work for this caller should stop. Costs a system call.
  [[nodiscard]] bool operator()() const { return deadline_over() || (gone && gone()); }
};

}  // namespace geodesic::server
