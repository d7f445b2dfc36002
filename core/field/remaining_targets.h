// Counts down the vertices that a field is to stop at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace geodesic {

class RemainingTargets {
 public:
  // `marks` is scratch memory and must outlive this object. It holds something other than zero for
  // each target.
  RemainingTargets(std::span<const std::uint32_t> targets, std::size_t vertex_count,
                   std::vector<std::uint8_t>& marks)
      : marks_(marks), all_(targets.empty()) {
    if (all_) return;
    marks_.assign(vertex_count, 0);
    for (const std::uint32_t v : targets) {
      if (marks_[v] == 0) ++left_;
      marks_[v] = kWanted;
    }
  }

  // The vertex has its final distance.
  void accept(std::uint32_t v) {
    if (all_ || marks_[v] != kWanted) return;
    marks_[v] = kAccepted;
    --left_;
  }
  // Never without targets: then every vertex is wanted.
  [[nodiscard]] bool done() const { return !all_ && left_ == 0; }

 private:
  static constexpr std::uint8_t kWanted = 1;
  static constexpr std::uint8_t kAccepted = 2;

  std::vector<std::uint8_t>& marks_;
  bool all_;
  std::size_t left_ = 0;
};

}  // namespace geodesic
