// Names that come twice in one JSON object: of two values, no reader can know which one is meant,
// and readers differ in which one they take (RFC 8259, section 4).
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace geodesic::proto {

// Told of all that nlohmann's parser comes to. Holds the names of the objects around, in order:
// names can be chosen so that a hash table becomes as slow as a list.
class RepeatedNames {
 public:
  // `parsed`: the parser's json or ordered_json.
  template <class Json>
  void note(typename Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) {
      open_.emplace_back();
    } else if (event == Json::parse_event_t::object_end && !open_.empty()) {
      open_.pop_back();
    } else if (event == Json::parse_event_t::key && !first_ && !open_.empty()) {
      const auto& name = parsed.template get_ref<const std::string&>();
      if (!open_.back().insert(name).second) first_ = name;
    }
  }
  // The first of them.
  [[nodiscard]] const std::optional<std::string>& first() const { return first_; }

 private:
  std::vector<std::set<std::string>> open_;  // names of the objects around
  std::optional<std::string> first_;
};

}  // namespace geodesic::proto
