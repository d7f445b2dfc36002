// How long a request's stages took: gathered on its way down, told in its
// Server-Timing header. One thread at a time adds.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace geodesic::server {

// In the order in which a request goes through them.
enum class Stage : std::uint8_t { queue, load, prepare, solve, search, trace, encode };
inline constexpr std::array<std::string_view, 7> kStageNames{"queue",  "load",  "prepare", "solve",
                                                             "search", "trace", "encode"};

class StageTimes {
 public:
  using Duration = std::chrono::duration<double>;  // seconds

  void add(Stage stage, Duration time) { times_[static_cast<std::size_t>(stage)] += time; }
  [[nodiscard]] Duration of(Stage stage) const { return times_[static_cast<std::size_t>(stage)]; }

 private:
  std::array<Duration, kStageNames.size()> times_{};
};

}  // namespace geodesic::server
