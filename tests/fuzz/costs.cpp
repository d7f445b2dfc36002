// Weights and slopes on a tiny mesh: a field of costs is held against lengths, and a way against
// the sum of what its segments cost.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/field/travel_cost.h"
#include "core/steiner/path.h"
#include "core/steiner/steiner.h"
#include "tests/fuzz/small_soup.h"

namespace geodesic::fuzz {
namespace {

constexpr double kRounding = 1e-7;  // relative

TravelCost::Parts some_parts(std::size_t faces, Reader& reader) {
  TravelCost::Parts parts;
  const std::uint8_t kind = reader.byte();
  if ((kind & 1U) != 0) {
    for (std::size_t f = 0; f < faces; ++f) {
      parts.weights.push_back(std::pow(10.0, reader.byte() % 7 - 3));
    }
  }
  if ((kind >> 1U) % 4 == 1) parts.rate = TravelCost::Rate::tobler;
  if ((kind >> 1U) % 4 == 2) parts.rate = TravelCost::Rate::energy;
  if ((kind >> 1U) % 4 == 3) {
    parts.rate = TravelCost::Rate::table;
    double slope = -2;
    for (int i = reader.byte() % 4; i >= 0; --i) {
      parts.table.push_back({slope, (1 + reader.byte()) / 32.0});
      slope += (1 + reader.byte()) / 64.0;
    }
  }
  if ((kind & 16U) != 0) parts.steepest = (1 + reader.byte()) / 64.0;
  parts.up = {(kind >> 5U & 1U) * 0.5, (kind >> 6U & 1U) * 0.5, 1};
  return parts;
}

Field field_of(const Adjacency& adjacency, const Source& source, std::uint32_t points,
               const std::shared_ptr<const TravelCost>& cost) {
  WavefrontScratch scratch;
  auto field = steiner_field(adjacency, {&source, 1}, points, {}, scratch, Cancel(), cost);
  expect(field.has_value(), "every mesh has a field of costs");
  return std::move(*field);
}

}  // namespace

void fuzz_costs(Input input) {
  Reader reader(input);
  const std::uint8_t which = reader.byte();
  std::vector<std::uint8_t> drawn;
  for (int i = 0; i < 70; ++i) drawn.push_back(reader.byte());
  const auto mesh = small_mesh(reader);
  if (mesh == nullptr) return;
  const Adjacency adjacency = Adjacency::build(mesh);

  Reader places(drawn);
  const Source source{small_point(adjacency, places), (which & 1U) * 2.5};
  const TravelCost::Parts parts = some_parts(mesh->face_count(), places);
  const auto cost = std::make_shared<const TravelCost>(parts);
  const std::uint32_t points = 1 + which / 2U % 3U;
  const Field costs = field_of(adjacency, source, points, cost);
  const Field lengths = field_of(adjacency, source, points, nullptr);
  // What a unit of length costs at least, and at most.
  double least = 1;
  double most = 1;
  if (!parts.weights.empty()) {
    least = *std::min_element(parts.weights.begin(), parts.weights.end());
    most = *std::max_element(parts.weights.begin(), parts.weights.end());
  }
  double least_rate = 1;
  double most_rate = 1;
  if (parts.rate == TravelCost::Rate::tobler) {
    least_rate = cost->rate_at(-0.05);
    most_rate = std::numeric_limits<double>::infinity();
  } else if (parts.rate == TravelCost::Rate::energy) {
    least_rate = 0.93;  // a little below the polynomial's minimum
    most_rate = cost->rate_at(std::numeric_limits<double>::infinity());
  } else if (parts.rate == TravelCost::Rate::table) {
    const auto less = [](const SlopeRate& a, const SlopeRate& b) { return a.rate < b.rate; };
    const auto [low, high] = std::minmax_element(parts.table.begin(), parts.table.end(), less);
    least_rate = low->rate;
    most_rate = high->rate;
  }
  // Tobler's rate has no bound: what is upright costs too much to be walked.
  const bool is_free = std::isinf(parts.steepest) && parts.rate != TravelCost::Rate::tobler;
  for (std::uint32_t v = 0; v < mesh->vertex_count(); ++v) {
    const double length = lengths.distance[v];
    const double d = costs.distance[v];
    expect(!std::isnan(d) && d >= 0, "a cost is not negative");
    if (length == kUnreached) {
      expect(d == kUnreached, "what has no way has no cost");
      continue;
    }
    expect(!is_free || d != kUnreached, "what may be walked and has a way has a cost");
    if (d == kUnreached) continue;
    const double bare = length - source.offset;
    const double lower = source.offset + least * least_rate * bare;
    expect(d >= lower * (1 - kRounding), "no cheaper than the cheapest ground");
    if (is_free) {
      expect(d <= (source.offset + most * most_rate * bare) * (1 + kRounding),
             "no dearer than the dearest");
    }
    WavefrontScratch scratch;
    MethodOptions options;
    options.points_per_edge = points;
    const auto path = steiner_path(adjacency, source, point_at_vertex(adjacency, v), options,
                                   scratch, Cancel(), cost);
    expect(path && *path, "what has a cost has a way");
    double sum = source.offset;
    for (const double segment : segment_costs(**path, *cost)) {
      expect(segment >= 0, "no segment pays");
      sum += segment;
    }
    expect(sum <= d * (1 + kRounding), "a way is no dearer than the field says");
    expect(sum >= (source.offset + least * least_rate * (*path)->length) * (1 - kRounding),
           "nor cheaper than its length allows");
  }
}

}  // namespace geodesic::fuzz
