#include "proto/wire/json_outline.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

namespace geodesic::proto {
namespace {

using nlohmann::json;

// The parser's events. (Its callback for values would tell as much, but the parser then goes
// through the whole array again after each object in it.)
class NameReader final : public nlohmann::json_sax<json> {
 public:
  explicit NameReader(std::size_t most_levels) : most_levels_(most_levels) {}

  bool start_object(std::size_t /*elements*/) override { return open(); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t /*elements*/) override { return open(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    if (!levels_.back().insert(name).second && !outline_.repeated_name) {
      outline_.repeated_name = name;
    }
    outline_.most_members = std::max(outline_.most_members, levels_.back().size());
    return true;
  }

  bool null() override { return true; }
  bool boolean(bool /*value*/) override { return true; }
  bool number_integer(number_integer_t /*value*/) override { return true; }
  bool number_unsigned(number_unsigned_t /*value*/) override { return true; }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return true; }
  bool string(string_t& /*value*/) override { return true; }
  bool binary(binary_t& /*value*/) override { return true; }
  bool parse_error(std::size_t /*place*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;  // whoever makes values of it will say so
  }

  [[nodiscard]] JsonOutline outline() && { return std::move(outline_); }

 private:
  bool open() {
    outline_.is_too_deep = levels_.size() >= most_levels_;
    if (!outline_.is_too_deep) levels_.emplace_back();
    return !outline_.is_too_deep;
  }
  bool close() {
    levels_.pop_back();
    return true;
  }

  std::size_t most_levels_;
  // The names of each object that is open. A set in order: names can be chosen so that a hash table
  // becomes as slow as a list.
  std::vector<std::set<std::string>> levels_;
  JsonOutline outline_;
};

}  // namespace

JsonOutline outline_of_json(std::string_view text, std::size_t most_levels, bool ignore_comments) {
  NameReader reader(most_levels);
  json::sax_parse(text, &reader, json::input_format_t::json, /*strict=*/true, ignore_comments);
  return std::move(reader).outline();
}

}  // namespace geodesic::proto
