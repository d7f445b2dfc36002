// What a decoder left out, took otherwise than it stands in the file, or made of
// it, by kind: how often, and where first.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace geodesic::proto {

struct Finding {
  std::string code;                   // for programs, such as "primitive_left_out"
  std::uint64_t count = 0;            // how many there are
  std::vector<std::string> examples;  // where the first few are, such as "mesh 0, primitive 2"
  std::string text;                   // one sentence for people
};

// Findings of one file, kinds in the order of their first.
class Findings {
 public:
  static constexpr std::size_t kMostExamples = 5;

  // `what` goes on the sentence that `where` begins; equal codes have equal ones.
  void add(std::string_view code, const std::string& where, std::string_view what,
           std::uint64_t count = 1);

  // With their sentences made.
  [[nodiscard]] std::vector<Finding> done() const;

 private:
  std::vector<std::pair<Finding, std::string>> kinds_;  // and what is found
};

}  // namespace geodesic::proto
