// Requests as clients write them: JSON bodies, URL queries, and points.
#include "proto/wire/requests.h"

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "proto/region/read_costs.h"
#include "proto/region/read_regions.h"
#include "proto/wire/parameters.h"
#include "proto/wire/point_request.h"
#include "server/http/head.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {
namespace {

std::string_view text_of(Input input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

void check_error(const Error& error) {
  expect(error.code != ErrorCode::internal, "an error is the client's");
  expect(!error.detail.empty(), "an error says what is wrong");
}

void check_point(const proto::PointRequest& point) {
  expect(std::isfinite(point.offset) && point.offset >= 0, "an offset is a length");
  if (const auto* face = std::get_if<proto::FaceRequest>(&point.where)) {
    double sum = 0;
    for (const double weight : face->bary) {
      expect(weight >= 0, "weights are not negative");
      sum += weight;
    }
    expect(std::abs(sum - 1) < 1e-6, "weights add up to one");
  }
  if (const auto* ray = std::get_if<proto::RayRequest>(&point.where)) {
    const Vec3 d = ray->direction;
    expect(d.x != 0 || d.y != 0 || d.z != 0, "a ray has a direction");
  }
  if (const auto* curve = std::get_if<std::shared_ptr<const proto::CurveRequest>>(&point.where)) {
    expect((*curve)->points.size() >= ((*curve)->is_closed ? 3 : 2), "a curve has points");
    for (const proto::PointRequest& one : (*curve)->points) {
      expect(one.is_point() && one.offset == 0, "a curve's points are points");
    }
  }
}

void check_source(const Result<proto::PointRequest>& source) {
  if (!source) return check_error(source.error());
  check_point(*source);
  if (const auto* faces = std::get_if<proto::FacesRequest>(&source->where)) {
    const auto shape = proto::parse_json_shape(nlohmann::json::parse(faces->shape), "from");
    if (!shape) check_error(shape.error());
  }
}

void check_line(const std::vector<proto::PointRequest>& points, std::size_t least) {
  expect(points.size() >= least, "a line has points enough");
  for (const proto::PointRequest& point : points) {
    expect(point.offset == 0, "a line's points have no offset");
    check_point(point);
  }
}

void check_regions(const proto::Regions& regions) {
  for (const proto::Wall& wall : regions.walls) {
    expect(!wall.parameter.empty(), "a wall knows its parameter");
    check_line(wall.points, 2);
  }
  for (const auto* region : {&regions.within, &regions.forbid}) {
    for (const proto::Shape& shape : *region) {
      expect(!shape.parameter.empty(), "a shape knows its parameter");
      if (const auto* faces = std::get_if<std::vector<proto::FaceRange>>(&shape.what)) {
        expect(!faces->empty(), "a list of faces has some");
        for (const auto& range : *faces) expect(range.first <= range.last, "a range has faces");
      }
      if (const auto* inside = std::get_if<proto::InsideShape>(&shape.what)) {
        check_line(inside->points, 3);
      }
      if (const auto* ball = std::get_if<proto::SphereShape>(&shape.what)) {
        expect(std::isfinite(ball->radius) && ball->radius >= 0, "a radius is a length");
      }
    }
  }
  expect(regions.is_everything() == (proto::canonical_text(regions) == "within forbid"),
         "the text of no regions is that of nothing else");
}

void check_costs(const proto::Costs& costs) {
  const auto is_price = [](double value) { return value >= 1e-9 && value <= 1e9; };
  for (const auto& region : costs.weights) expect(is_price(region.weight), "a weight is a price");
  expect(costs.weight_attribute.empty() || costs.face_weights.empty(), "weights come one way");
  for (const double weight : costs.face_weights) expect(is_price(weight), "so is a face's");
  const TravelCost cost(costs.walk);
  for (const double slope : {-1e9, -1.0, 0.0, 0.3}) {
    const double rate = cost.rate_at(slope);
    expect(costs.walk.rate == TravelCost::Rate::tobler || (rate > 0.99e-9 && rate < 1.01e9),
           "rates are between those of the table");
  }
  expect(std::abs(norm(costs.walk.up) - 1) < 1e-6, "up is a direction");
  expect(costs.are_lengths() ==
             (proto::canonical_text(costs) == proto::canonical_text(proto::Costs{})),
         "the text of no costs is that of nothing else");
}

template <class Request>
void parse(const auto& parameters_of) {
  auto parameters = parameters_of();
  if (!parameters) return check_error(parameters.error());
  Request request{};
  const auto parsed = proto::parse_request(*parameters, request);
  if (!parsed) return check_error(parsed.error());
  if constexpr (requires { request.all_rows; }) {
    expect(!request.from.empty(), "a table has rows");
    expect(request.first_row + request.from.size() <= request.all_rows,
           "its rows are those it has");
    for (const proto::PointRequest& column : request.to) {
      expect(column.is_point() || request.landmarks == 0, "columns that are estimated are points");
      expect(column.offset == 0, "columns have no offset");
    }
  }
  if constexpr (requires { request.relax; }) {
    for (const proto::PointRequest& site : request.from) {
      expect(site.is_point() || request.relax == 0, "only points move");
    }
  }
  const auto regions = proto::read_regions(*parameters);
  if (!regions) return check_error(regions.error());
  check_regions(*regions);
  const auto costs = proto::read_costs(*parameters);
  if (!costs) return check_error(costs.error());
  check_costs(*costs);
  const auto format = proto::parse_format(*parameters, nullptr, proto::formats_of(request));
  if (!format) return check_error(format.error());
  if (const auto known = parameters->check_all_known(); !known) check_error(known.error());
}

void parse_all(const auto& parameters_of) {
  parse<proto::DistanceRequest>(parameters_of);
  parse<proto::PathRequest>(parameters_of);
  parse<proto::TableRequest>(parameters_of);
  parse<proto::IsolinesRequest>(parameters_of);
  parse<proto::SamplesRequest>(parameters_of);
  parse<proto::TraceRequest>(parameters_of);
  parse<proto::MeasureRequest>(parameters_of);
  parse<proto::ExtentRequest>(parameters_of);
  parse<proto::VoronoiRequest>(parameters_of);
  parse<proto::LoopRequest>(parameters_of);
  parse<proto::LogmapRequest>(parameters_of);
  parse<proto::NearestRequest>(parameters_of);
}

}  // namespace

void fuzz_requests(Input input) {
  const std::string_view text = text_of(input);
  parse_all([&] { return proto::Parameters::from_json(text); });
  parse_all([&]() -> Result<proto::Parameters> {
    auto query = server::parse_query(text);
    if (!query) return fail(std::move(query.error()));
    return proto::Parameters::from_query(*query);
  });
}

void fuzz_points(Input input) {
  const std::string_view text = text_of(input);
  const auto point = proto::parse_point(text, "from[3]");
  if (!point) {
    check_error(point.error());
    expect(point.error().parameter == "from[3]", "an error names its parameter");
  } else {
    check_point(*point);
    expect(point->parameter == "from[3]", "a point knows its parameter");
  }
  // A text is the same point in JSON.
  const auto in_json = proto::parse_json_point(nlohmann::json(std::string(text)), "from[3]");
  expect(in_json.has_value() == point.has_value(), "JSON takes the URL's text");
  const auto source = proto::parse_source(text, "from[3]");
  expect(!point || source, "a point is a source");
  check_source(source);
  const auto value = nlohmann::json::parse(text, nullptr, false);
  if (value.is_discarded()) return;
  check_source(proto::parse_json_source(value, "from"));
  const auto structured = proto::parse_json_point(value, "to");
  if (structured) {
    check_point(*structured);
  } else {
    check_error(structured.error());
  }
}

}  // namespace geodesic::fuzz
