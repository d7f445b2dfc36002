#include "proto/mesh/findings.h"

#include <algorithm>

namespace geodesic::proto {

void Findings::add(std::string_view code, const std::string& where, std::string_view what,
                   std::uint64_t count) {
  auto kind =
      std::ranges::find_if(kinds_, [&](const auto& known) { return known.first.code == code; });
  if (kind == kinds_.end()) {
    kind = kinds_.insert(kinds_.end(), {Finding{std::string(code), 0, {}, {}}, std::string(what)});
  }
  kind->first.count += count;
  if (kind->first.examples.size() < kMostExamples) kind->first.examples.push_back(where);
}

std::vector<Finding> Findings::done() const {
  std::vector<Finding> findings;
  for (const auto& [finding, what] : kinds_) {
    Finding done = finding;
    done.text = finding.examples.front() + " " + what;
    if (finding.count > 1) done.text += " (and " + std::to_string(finding.count - 1) + " more)";
    done.text += ".";
    findings.push_back(std::move(done));
  }
  return findings;
}

}  // namespace geodesic::proto
