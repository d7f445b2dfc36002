// Threads that are lent to a computation for as long as nobody else wants them.
//
// Core starts no threads. Whoever calls may give a computation a Team (in its Cancel), and send
// threads of its own into `help`, at any time and for as long as it likes. The computation divides
// steps of some microseconds into parts (`run`). Each part is done once, by the computing thread or
// by one that helps. Where there are no more parts than threads, that is if possible the one that
// did the part of that number in the last step: what it read and wrote is still in that processor's
// cache. No result may depend on who did what, nor on whether anybody helped. So short are the
// steps that threads wait for the next one by asking again and again; only when none has come for a
// millisecond do they sleep in between.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <type_traits>

#include "core/base/cancel.h"

namespace geodesic {

class Team {
 public:
  static constexpr std::size_t kMostParts = 64;
  // On smaller meshes telling other threads what to do takes as long as doing it.
  static constexpr std::size_t kFewestVertices = 150'000;

  // `threads`: how many may be there at once, as far as can be told; the computing thread is one.
  // `fewest_vertices`: computations on meshes of fewer are not divided; tests want it to happen on
  // small ones.
  explicit Team(std::size_t threads, std::size_t fewest_vertices = kFewestVertices)
      : threads_(std::clamp(threads, std::size_t{1}, kMostParts)),
        fewest_vertices_(fewest_vertices) {}
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;
  // Nobody may be in `help` any more.
  ~Team() = default;

  // For a thread that helps. Does parts until `leave`, which it asks after each step and every few
  // microseconds, says true; or until `end` was called, or the computation goes on alone, because
  // parts were late: where other processes use the processors too, who has begun one may lose its
  // core.
  void help(const std::function<bool()>& leave);

  // Sends those that help away, now and in future. Any thread.
  void end() { is_over_.store(true, std::memory_order_relaxed); }

  // Into how many parts that take as long a computation on such a mesh is best divided.
  [[nodiscard]] std::size_t parts_for(std::size_t vertices) const {
    return vertices < fewest_vertices_ ? 1 : threads_;
  }

  // Whether nobody may help any more.
  [[nodiscard]] bool is_over() const { return is_over_.load(std::memory_order_relaxed); }

  // For the computing thread: does `work(part, poll)` for each part from 0 to `parts` - 1, which is
  // at most kMostParts. All are done when it returns. The work asks the poll that it is given: the
  // computing thread's own or another, and that one for memory: what it grants others is asked for
  // when all parts are done. If parts throw, so does this, what one of them threw.
  //
  // The work is a few values, which lie beside the number of the step. In steps of microseconds it
  // captures no references to locals: to wait for each of those from another thread's cache takes
  // longer than a part.
  template <class Work>
  void run(std::size_t parts, Poll& poll, const Work& work) {
    static_assert(std::is_trivially_copyable_v<Work> && sizeof(Work) <= kMostOfWork);
    if (parts <= 1 || helping_.load(std::memory_order_relaxed) == 0) {
      for (std::size_t part = 0; part < parts; ++part) work(part, poll);
      return;
    }
    std::memcpy(work_.data(), &work, sizeof work);
    call_ = [](const void* given, std::size_t part, Poll& asked) {
      (*static_cast<const Work*>(given))(part, asked);
    };
    share(static_cast<std::uint32_t>(parts), poll);
  }

 private:
  using Call = void (*)(const void*, std::size_t, Poll&);
  // Bytes: processors fetch cache lines, of 64 bytes, two at a time.
  static constexpr std::size_t kApart = 128;
  // The numbers of the last steps in which a part was begun and done. A cache line each: the first
  // stays with who does the part, the other is looked at by the computing thread meanwhile.
  struct Place {
    alignas(kApart) std::atomic<std::uint32_t> begun{0};
    alignas(kApart) std::atomic<std::uint32_t> done{0};
  };

  void share(std::uint32_t parts, Poll& poll);
  // Begins the part, unless somebody has.
  [[nodiscard]] bool begin(std::uint32_t part, std::uint32_t step);
  void do_part(std::uint32_t part, std::uint32_t step, Poll& poll) noexcept;

  static constexpr std::size_t kMostOfWork = 40;  // bytes

  // The step that runs or ran last: its number, and in the lower half its parts. Who has begun a
  // part of it may read what the work is: until the part is done it does not change.
  alignas(kApart) std::atomic<std::uint64_t> step_{0};
  Call call_ = nullptr;
  alignas(8) std::array<std::byte, kMostOfWork> work_{};
  alignas(kApart) std::array<Place, kMostParts> places_;
  const std::size_t threads_;
  const std::size_t fewest_vertices_;
  std::atomic<bool> is_stopped_{false};  // the computing thread's poll has said so
  std::atomic<bool> is_over_{false};
  std::atomic<std::uint32_t> helping_{0};
  std::atomic<std::uint32_t> came_{0};
  std::atomic<bool> has_thrown_{false};
  std::exception_ptr thrown_;            // by who set `has_thrown_`
  std::atomic<std::uint64_t> taken_{0};  // bytes, by those that helped
  std::uint64_t asked_for_ = 0;          // of these
  // How long the computing thread has worked in steps that others help with, and waited for late
  // parts: nanoseconds.
  std::int64_t worked_ = 0;
  std::int64_t waited_ = 0;
};

// The same for a computation that may have nobody to help it.
template <class Work>
void run_parts(std::size_t parts, Poll& poll, const Work& work) {
  if (Team* const team = poll.team()) return team->run(parts, poll, work);
  for (std::size_t part = 0; part < parts; ++part) work(part, poll);
}

// Into how many ranges run_in_ranges divides `count` things, about as many as the mesh has
// vertices: a few for each thread, for one may come late.
[[nodiscard]] inline std::size_t count_ranges(std::size_t count, const Poll& poll) {
  constexpr std::size_t kOfThread = 4;
  const Team* const team = poll.team();
  const std::size_t threads = team == nullptr ? 1 : team->parts_for(count);
  return threads == 1 ? 1 : std::min(kOfThread * threads, Team::kMostParts);
}

// `work(range, begin, end, poll)` for the ranges of [0, count), by whoever is there.
template <class Work>
void run_in_ranges(std::size_t count, Poll& poll, const Work& work) {
  const std::size_t ranges = count_ranges(count, poll);
  run_parts(ranges, poll, [count, ranges, &work](std::size_t range, Poll& asked) {
    work(range, range * count / ranges, (range + 1) * count / ranges, asked);
  });
}

// Things are gone through in blocks of so many where the result must not depend on how many threads
// there are, though it does on where a block ends: sums, or what is done within a block alone. Some
// milliseconds each, after which a thread that helps may leave.
inline constexpr std::size_t kBlock = std::size_t{1} << 15U;
[[nodiscard]] constexpr std::size_t count_blocks(std::size_t count) {
  return (count + kBlock - 1) / kBlock;
}

// `work(block, begin, end, poll)` for the blocks of [0, count), by whoever is there. Not for all if
// the poll says to stop.
template <class Work>
void run_in_blocks(std::size_t count, Poll& poll, const Work& work) {
  const std::size_t blocks = count_blocks(count);
  const std::size_t at_once = count_ranges(count, poll);
  for (std::size_t first = 0; first < blocks && !poll.stopped(); first += at_once) {
    run_parts(std::min(at_once, blocks - first), poll,
              [count, first, &work](std::size_t part, Poll& asked) {
                const std::size_t block = first + part;
                work(block, block * kBlock, std::min(count, (block + 1) * kBlock), asked);
              });
  }
}

}  // namespace geodesic
