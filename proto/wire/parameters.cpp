#include "proto/wire/parameters.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "proto/wire/json_outline.h"
#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

// No query nests deeper than a list of points with lists of numbers.
constexpr int kMaxDepth = 8;

// A finite number, or a text that is one.
std::optional<double> finite_number(const json& value) {
  if (value.is_string()) return parse_finite(value.get_ref<const std::string&>());
  if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
  return value.get<double>();
}

}  // namespace

struct Parameters::Values {
  json by_name = json::object();  // every value an array of what came under that name
  std::vector<std::string> asked;
  std::vector<std::string> lists;  // names that came with a list, of any length

  [[nodiscard]] bool is_list(std::string_view name) const {
    return std::find(lists.begin(), lists.end(), name) != lists.end();
  }
  // The values under a name, as an array; null when there are none.
  const json* find(std::string_view name) {
    asked.emplace_back(name);
    const auto it = by_name.find(name);
    return it == by_name.end() ? nullptr : &*it;
  }
  Result<const json*> find_one(std::string_view name) {
    const json* values = find(name);
    if (values == nullptr) return nullptr;
    if (values->size() != 1 || is_list(name)) {
      return fail(InputCode::bad_syntax, "this parameter takes one value", std::string(name));
    }
    return &values->front();
  }

  using Parse = Result<PointRequest> (*)(const json&, std::string);
  // All values under a name.
  Result<std::vector<PointRequest>> read(std::string_view name, Parse parse) {
    std::vector<PointRequest> points;
    const json* values = find(name);
    if (values == nullptr) return points;
    points.reserve(values->size());
    for (std::size_t i = 0; i < values->size(); ++i) {
      auto point = parse((*values)[i], std::string(name) + "[" + std::to_string(i) + "]");
      if (!point) return fail(std::move(point.error()));
      points.push_back(std::move(*point));
    }
    return points;
  }
  // The only one there may be.
  Result<PointRequest> read_one(std::string_view name, Parse parse) {
    const auto it = by_name.find(name);
    if ((it != by_name.end() && it->size() > 1) || is_list(name)) {
      return fail(InputCode::bad_syntax, "this parameter takes one point", std::string(name));
    }
    auto all = read(name, parse);
    if (!all) {
      // It has no number.
      std::string& where = all.error().parameter;
      const std::string first = std::string(name) + "[0]";
      if (where.starts_with(first)) where.erase(name.size(), first.size() - name.size());
      return fail(std::move(all.error()));
    }
    if (all->empty()) {
      return fail(InputCode::bad_syntax, "this parameter is missing", std::string(name));
    }
    all->front().parameter = std::string(name);
    return std::move(all->front());
  }
};

Parameters::Parameters(std::unique_ptr<Values> values) : values_(std::move(values)) {}
Parameters::Parameters(Parameters&&) noexcept = default;
Parameters& Parameters::operator=(Parameters&&) noexcept = default;
Parameters::~Parameters() = default;

Parameters Parameters::from_query(const std::vector<std::pair<std::string, std::string>>& query) {
  auto values = std::make_unique<Values>();
  for (const auto& [name, value] : query) values->by_name[name].push_back(value);
  return Parameters(std::move(values));
}

Result<Parameters> Parameters::from_json(std::string_view body) {
  auto values = std::make_unique<Values>();
  const JsonOutline outline = outline_of_json(body, kMaxDepth);
  if (outline.is_too_deep) {
    return fail(InputCode::bad_syntax, "the body is nested too deeply", "body");
  }
  json document;
  try {
    document = json::parse(body);
  } catch (const json::exception& error) {
    const auto* parse_error = dynamic_cast<const json::parse_error*>(&error);
    return fail(InputCode::bad_syntax,
                parse_error != nullptr
                    ? "the body is not JSON from byte " + std::to_string(parse_error->byte)
                    : "the body is not JSON that can be read",
                "body");
  }
  if (outline.repeated_name) {
    return fail(InputCode::bad_syntax, "this name comes twice in one JSON object",
                *outline.repeated_name);
  }
  if (!document.is_object()) {
    return fail(InputCode::bad_syntax, "the body is not a JSON object", "body");
  }
  for (auto& [name, value] : document.items()) {
    if (value.is_array()) values->lists.push_back(name);
    values->by_name[name] = value.is_array() ? std::move(value) : json::array({std::move(value)});
  }
  return Parameters(std::move(values));
}

std::size_t Parameters::count(std::string_view name) const {
  const auto it = values_->by_name.find(name);
  return it == values_->by_name.end() ? 0 : it->size();
}

Result<std::vector<PointRequest>> Parameters::points(std::string_view name) {
  return values_->read(name, parse_json_point);
}

Result<std::vector<PointRequest>> Parameters::sources(std::string_view name) {
  return values_->read(name, parse_json_source);
}

Result<PointRequest> Parameters::point(std::string_view name) {
  return values_->read_one(name, parse_json_point);
}

Result<PointRequest> Parameters::source(std::string_view name) {
  return values_->read_one(name, parse_json_source);
}

Result<std::optional<double>> Parameters::number(std::string_view name) {
  const auto value = values_->find_one(name);
  if (!value) return fail(value.error());
  if (*value == nullptr) return std::optional<double>();
  const auto number = finite_number(**value);
  if (!number) return fail(InputCode::bad_syntax, "this is not a number", std::string(name));
  return number;
}

Result<std::optional<std::uint64_t>> Parameters::whole(std::string_view name) {
  const auto value = values_->find_one(name);
  if (!value) return fail(value.error());
  if (*value == nullptr) return std::optional<std::uint64_t>();
  std::optional<std::uint64_t> number;
  if ((*value)->is_string()) number = parse_whole((*value)->get_ref<const std::string&>());
  if ((*value)->is_number()) number = whole_number(**value);
  if (!number) {
    return fail(InputCode::bad_syntax, "this is not a whole number of zero or more",
                std::string(name));
  }
  return number;
}

Result<std::optional<std::string>> Parameters::text(std::string_view name) {
  const auto value = values_->find_one(name);
  if (!value) return fail(value.error());
  if (*value == nullptr) return std::optional<std::string>();
  if (!(*value)->is_string()) {
    return fail(InputCode::bad_syntax, "this is not a text", std::string(name));
  }
  return std::optional((*value)->get<std::string>());
}

Result<std::optional<std::string>> Parameters::scalar(std::string_view name) {
  const auto value = values_->find_one(name);
  if (!value) return fail(value.error());
  if (*value == nullptr) return std::nullopt;
  if (!(*value)->is_number() && !(*value)->is_string()) {
    return fail(InputCode::bad_syntax, "this is a number or a text", std::string(name));
  }
  return (*value)->dump();
}

Result<std::optional<bool>> Parameters::flag(std::string_view name) {
  const auto value = values_->find_one(name);
  if (!value) return fail(value.error());
  if (*value == nullptr) return std::optional<bool>();
  for (const bool state : {false, true}) {
    if (**value == json(state) || **value == json(state ? 1 : 0) ||
        **value == json(state ? "1" : "0") || **value == json(state ? "true" : "false")) {
      return std::optional(state);
    }
  }
  return fail(InputCode::bad_syntax, "this is neither 1 nor 0", std::string(name));
}

Result<std::vector<double>> Parameters::numbers(std::string_view name) {
  std::vector<double> numbers;
  const json* values = values_->find(name);
  if (values == nullptr) return numbers;
  numbers.reserve(values->size());
  for (const json& value : *values) {
    const auto number = finite_number(value);
    if (!number) {
      return fail(InputCode::bad_syntax, "this is not a number",
                  std::string(name) + "[" + std::to_string(numbers.size()) + "]");
    }
    numbers.push_back(*number);
  }
  return numbers;
}

Result<std::optional<Vec3>> Parameters::vector(std::string_view name) {
  const json* values = values_->find(name);
  if (values == nullptr) return std::optional<Vec3>();
  std::vector<double> numbers;
  if (values->size() == 1 && values->front().is_string() && !values_->is_list(name)) {
    numbers = numbers_between_commas(values->front().get_ref<const std::string&>())
                  .value_or(std::vector<double>());
  } else {
    for (const json& value : *values) {
      if (const auto number = finite_number(value); number && value.is_number()) {
        numbers.push_back(*number);
      }
    }
    if (numbers.size() != values->size()) numbers.clear();
  }
  if (numbers.size() != 3) {
    return fail(InputCode::bad_syntax, "a vector is written X,Y,Z, or in JSON [x,y,z]",
                std::string(name));
  }
  return std::optional(Vec3{numbers[0], numbers[1], numbers[2]});
}

const json* Parameters::values(std::string_view name) { return values_->find(name); }

Result<void> Parameters::check_all_known() const {
  for (const auto& [name, value] : values_->by_name.items()) {
    if (std::find(values_->asked.begin(), values_->asked.end(), name) == values_->asked.end()) {
      return fail(InputCode::unknown_parameter, "this call has no such parameter",
                  name.substr(0, 64));
    }
  }
  return {};
}

}  // namespace geodesic::proto
