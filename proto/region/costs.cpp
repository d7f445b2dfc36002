#include "proto/region/costs.h"

#include <limits>

#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

void append_text(std::string& out, std::string_view name, double value) {
  out += name;
  append_number(out, value);
}

}  // namespace

bool Costs::are_lengths() const {
  return !have_weights() && walk.rate == TravelCost::Rate::none &&
         walk.steepest == std::numeric_limits<double>::infinity();
}

NamedOfFile Costs::named_of_file() const {
  NamedOfFile named;
  for (const WeightedRegion& region : weights) named.add(region.shape);
  return named;
}

std::string_view unit_of(const Costs& costs) {
  if (costs.walk.rate == TravelCost::Rate::tobler) return "seconds";
  if (costs.walk.rate == TravelCost::Rate::energy) return "joules_per_kilogram";
  return costs.walk.rate == TravelCost::Rate::none ? "length" : "cost";
}

std::string canonical_text(const Costs& costs) {
  std::string text;
  if (!costs.weight_attribute.empty()) {
    // With its length, so that it cannot pass for what follows.
    text += "attribute " + std::to_string(costs.weight_attribute.size()) + ':';
    text += costs.weight_attribute;
  } else {
    text += "faces";
    for (const double weight : costs.face_weights) append_text(text, " ", weight);
  }
  for (const WeightedRegion& region : costs.weights) {
    append_text(text, " weight ", region.weight);
    text += ' ';
    text += canonical_text(Regions{.within = {region.shape}, .forbid = {}, .walls = {}});
  }
  text += " rate ";
  text += std::to_string(static_cast<int>(costs.walk.rate));
  for (const SlopeRate& entry : costs.walk.table) {
    append_text(text, " ", entry.slope);
    append_text(text, ":", entry.rate);
  }
  append_text(text, " steepest ", costs.walk.steepest);
  const Vec3 up = costs.walk.up;
  for (const double along : {up.x, up.y, up.z}) append_text(text, " ", along);
  return text;
}

}  // namespace geodesic::proto
