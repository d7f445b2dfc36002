#include "proto/region/read_costs.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "proto/region/read_regions.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"
#include "proto/wire/point_request.h"
#include "proto/wire/query_limits.h"
#include "proto/wire/reply_format.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

std::string numbered(std::string_view name, std::size_t i) {
  return std::string(name).append("[").append(std::to_string(i)).append("]");
}

// Products and sums of these are numbers still.
Result<void> check_price(double price, std::string parameter) {
  if (price >= kLeastWeight && price <= kMostWeight) return {};
  return fail(ErrorCode::value_out_of_range,
              "a weight or a cost is from 1e-9 to 1e9; what must not be walked on is forbidden by "
              "forbid",
              std::move(parameter));
}

Result<WeightedRegion> checked(Result<Shape> shape, double weight, const std::string& parameter) {
  if (!shape) return fail(std::move(shape.error()));
  if (auto fine = check_price(weight, parameter + ".weight"); !fine) {
    return fail(std::move(fine.error()));
  }
  return WeightedRegion{std::move(*shape), weight};
}

Result<WeightedRegion> weighted_region(const json& value, const std::string& parameter) {
  if (value.is_string()) {
    const std::string_view text = value.get_ref<const std::string&>();
    const std::size_t star = text.find('*');
    const auto weight = parse_finite(text.substr(0, star));
    if (star == std::string_view::npos || !weight) {
      return fail(InputCode::bad_syntax, "a weight is written NUMBER*REGION, such as 3*faces:10-99",
                  parameter);
    }
    return checked(parse_shape(text.substr(star + 1), parameter), *weight, parameter);
  }
  if (!value.is_object() || !value.contains("weight") || !value.contains("region") ||
      !value["weight"].is_number()) {
    return fail(InputCode::bad_syntax,
                R"(a weight is an object with "weight", a number, and "region", or a text)",
                parameter);
  }
  if (auto only = check_only_has(value, {"weight", "region"}, "a weight", parameter); !only) {
    return fail(std::move(only.error()));
  }
  return checked(parse_json_shape(value["region"], parameter + ".region"),
                 value["weight"].get<double>(), parameter);
}

Result<void> read_weights(Parameters& parameters, Costs& costs) {
  const std::size_t count = parameters.count("weights");
  if (count > kMaxRegionShapes) {
    return fail_limit(ErrorCode::too_large,
                      "too many weighted regions; ranges of faces take one, and face_weights takes "
                      "a weight for each face",
                      kMaxRegionShapes, count, "weights");
  }
  const json* values = parameters.values("weights");
  if (values == nullptr) return {};
  std::uint64_t ranges = 0;
  for (std::size_t i = 0; i < values->size(); ++i) {
    auto region = weighted_region((*values)[i], numbered("weights", i));
    if (!region) return fail(std::move(region.error()));
    if (const auto* faces = std::get_if<std::vector<FaceRange>>(&region->shape.what)) {
      ranges += faces->size();
      if (ranges > kMaxFaceRanges) {
        return fail_limit(ErrorCode::too_large,
                          "too many faces and ranges of them in one request; write what lies side "
                          "by side as one range, or all weights as face_weights",
                          kMaxFaceRanges, ranges, "weights");
      }
    }
    costs.weights.push_back(std::move(*region));
  }
  return {};
}

Result<void> read_face_weights(Parameters& parameters, Costs& costs) {
  const json* given = parameters.values("face_weights");
  if (given != nullptr && given->empty()) {
    return fail(InputCode::bad_syntax, "a weight for each source face is wanted", "face_weights");
  }
  auto weights = parameters.numbers("face_weights");
  if (!weights) return fail(std::move(weights.error()));
  for (std::size_t i = 0; i < weights->size(); ++i) {
    if (auto fine = check_price((*weights)[i], numbered("face_weights", i)); !fine) return fine;
  }
  costs.face_weights = std::move(*weights);
  if (auto read = read_attribute(parameters, "weight_attribute", costs.weight_attribute); !read) {
    return read;
  }
  if (!costs.weight_attribute.empty() && given != nullptr) {
    return fail(InputCode::bad_syntax,
                "weights of faces are sent, or read from an attribute of the file, not both",
                "weight_attribute");
  }
  return {};
}

tl::unexpected<Error> no_slope(std::string parameter = "slope") {
  return fail(InputCode::bad_syntax,
              "slope is tobler, energy, or pairs of a slope and the cost of a unit of length "
              "there, such as "
              "-0.5:2,0:1,0.5:3",
              std::move(parameter));
}

// "-0.5:2,0:1,0.5:3"
Result<std::vector<SlopeRate>> table_of(std::string_view text) {
  std::vector<SlopeRate> table;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::string_view entry = text.substr(0, comma);
    const std::size_t colon = entry.find(':');
    if (colon == std::string_view::npos) return no_slope();
    const auto slope = parse_finite(entry.substr(0, colon));
    const auto rate = parse_finite(entry.substr(colon + 1));
    if (!slope || !rate) return no_slope();
    table.push_back({*slope, *rate});
    if (comma == std::string_view::npos) return table;
    text.remove_prefix(comma + 1);
  }
}

// [[-0.5, 2], [0, 1], [0.5, 3]]
Result<std::vector<SlopeRate>> table_of(const json& values) {
  std::vector<SlopeRate> table;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto pair = finite_numbers(values[i], 2);
    if (!pair) return no_slope(numbered("slope", i));
    table.push_back({(*pair)[0], (*pair)[1]});
  }
  return table;
}

Result<void> read_slope(Parameters& parameters, TravelCost::Parts& walk) {
  const std::size_t count = parameters.count("slope");
  const json* values = parameters.values("slope");
  if (values == nullptr) return {};
  if (count > kMaxSlopes) {
    return fail_limit(ErrorCode::too_large, "too many slopes in one table", kMaxSlopes, count,
                      "slope");
  }
  if (values->empty()) return no_slope();
  const json& first = values->front();
  Result<std::vector<SlopeRate>> table;
  if (first.is_string()) {
    if (count > 1) return no_slope("slope");
    const std::string_view text = first.get_ref<const std::string&>();
    if (text == "tobler" || text == "energy") {
      walk.rate = text == "tobler" ? TravelCost::Rate::tobler : TravelCost::Rate::energy;
      return {};
    }
    table = table_of(text);
  } else {
    table = table_of(*values);
  }
  if (!table) return fail(std::move(table.error()));
  if (table->size() > kMaxSlopes) {
    return fail_limit(ErrorCode::too_large, "too many slopes in one table", kMaxSlopes,
                      table->size(), "slope");
  }
  for (std::size_t i = 0; i < table->size(); ++i) {
    if (auto fine = check_price((*table)[i].rate, numbered("slope", i)); !fine) return fine;
    if (!(std::abs((*table)[i].slope) <= kMostWeight)) {
      return fail(ErrorCode::value_out_of_range, "a slope of a table is from -1e9 to 1e9",
                  numbered("slope", i));
    }
    if (i > 0 && !((*table)[i - 1].slope < (*table)[i].slope)) {
      return fail(ErrorCode::value_out_of_range, "the slopes of a table ascend",
                  numbered("slope", i));
    }
  }
  walk.rate = TravelCost::Rate::table;
  walk.table = std::move(*table);
  return {};
}

}  // namespace

Result<Costs> read_costs(Parameters& parameters) {
  Costs costs;
  if (auto read = read_weights(parameters, costs); !read) return fail(std::move(read.error()));
  if (auto read = read_face_weights(parameters, costs); !read) {
    return fail(std::move(read.error()));
  }
  if (auto read = read_slope(parameters, costs.walk); !read) return fail(std::move(read.error()));
  const auto steepest = parameters.number("steepest");
  if (!steepest) return fail(steepest.error());
  if (*steepest && !(**steepest > 0)) {
    return fail(ErrorCode::value_out_of_range,
                "steepest is above 0: the rise for each unit of length on the map", "steepest");
  }
  if (*steepest) costs.walk.steepest = **steepest;
  const auto up = parameters.vector("up");
  if (!up) return fail(up.error());
  if (!*up) return costs;
  if (costs.walk.rate == TravelCost::Rate::none && !*steepest) {
    return fail(InputCode::unknown_parameter, "up says something with slope or steepest alone",
                "up");
  }
  const double length = norm(**up);
  if (!(length > 0 && std::isfinite(length) && std::isfinite(1 / length))) {
    return fail(
        ErrorCode::value_out_of_range,
        "up is a vector whose length is not zero, nor too large or too small for its square", "up");
  }
  costs.walk.up = 1 / length * **up;
  return costs;
}

}  // namespace geodesic::proto
