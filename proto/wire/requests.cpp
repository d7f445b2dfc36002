#include "proto/wire/requests.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"
#include "proto/wire/query_limits.h"
#include "proto/wire/query_parameters.h"

namespace geodesic::proto {
namespace {

// Leaves of a table the rows `first-last`, counted from 0; without the last all from the first on.
Result<void> take_rows(std::string_view text, TableRequest& request) {
  const std::uint64_t count = request.from.size();
  std::uint64_t first = 0;
  std::uint64_t last = count - 1;
  const char* const end = text.data() + text.size();
  const auto begun = std::from_chars(text.data(), end, first);
  bool is_read = begun.ec == std::errc() && begun.ptr != end && *begun.ptr == '-';
  if (is_read && begun.ptr + 1 != end) {
    const auto ended = std::from_chars(begun.ptr + 1, end, last);
    is_read = ended.ec == std::errc() && ended.ptr == end;
  }
  if (!is_read) {
    return fail(
        InputCode::bad_syntax,
        "rows are first-last, such as 500-999, or first- for all that follow, counted from 0",
        "rows");
  }
  if (first > last || last >= count) {
    return fail_limit(ErrorCode::value_out_of_range,
                      "rows are counted from 0 to the last of the table's, and the first is not "
                      "behind the last",
                      count - 1, std::max(first, last), "rows");
  }
  if (request.to.empty()) request.to = request.from;
  const auto at = [&](std::uint64_t row) {
    return request.from.begin() + static_cast<std::ptrdiff_t>(row);
  };
  request.from.erase(at(last + 1), request.from.end());
  request.from.erase(request.from.begin(), at(first));
  request.first_row = first;
  return {};
}

Result<void> read_refine(Parameters& parameters, Refine& refine) {
  const auto name = parameters.text("refine");
  if (!name) return fail(name.error());
  const std::string which = name->value_or("shortest");
  if (which != "none" && which != "shortest") {
    return fail(ErrorCode::value_out_of_range, "refine is none or shortest", "refine");
  }
  refine = which == "shortest" ? Refine::shortest : Refine::none;
  return {};
}

// By ExtentRequest::Of.
constexpr std::array<std::string_view, 5> kExtentNames{"diameter", "center", "median", "mean",
                                                       "means"};

// By VoronoiRequest::Part.
constexpr std::array<std::string_view, 3> kVoronoiParts{"cells", "bisectors", "delaunay"};

// By LoopRequest::Start; a plane is told by the point that it goes through.
constexpr std::array<std::string_view, 3> kLoopNames{"through", "around", "at"};

// Which of them is given, which only one may be.
Result<LoopRequest::Start> read_start(const Parameters& parameters) {
  std::optional<std::size_t> start;
  for (std::size_t i = 0; i < kLoopNames.size(); ++i) {
    if (parameters.count(kLoopNames[i]) == 0) continue;
    if (start) {
      return fail(InputCode::bad_syntax, "only one of through, around and at",
                  std::string(kLoopNames[i]));
    }
    start = i;
  }
  if (!start) {
    return fail(InputCode::bad_syntax, "one of through, around and at is needed", "through");
  }
  return static_cast<LoopRequest::Start>(*start);
}

// `hull`; refuses a method where the loop is of a plane.
Result<void> read_hull(Parameters& parameters, LoopRequest& request) {
  const auto hull = parameters.flag("hull");
  if (!hull) return fail(hull.error());
  request.hull = hull->value_or(false);
  if (request.is_of_plane() && parameters.count("method") > 0) {
    return fail(InputCode::unknown_parameter, "a plane needs no method: its section is no path",
                "method");
  }
  return {};
}

Result<void> read_plane(Parameters& parameters, LoopRequest& request) {
  if (auto ok = read_point(parameters, "at", request.points.emplace_back()); !ok) return ok;
  const auto normal = parameters.vector("normal");
  if (!normal) return fail(normal.error());
  if (!*normal) return missing("normal");
  request.normal = **normal;
  return read_hull(parameters, request);
}

// Whether the sources may be a line with two sides; only the mesh says whether it has.
Result<void> check_has_sides(const std::vector<PointRequest>& from) {
  const auto* curve = std::get_if<std::shared_ptr<const CurveRequest>>(&from.front().where);
  if (from.size() == 1 && curve != nullptr && (*curve)->is_closed) return {};
  return fail(ErrorCode::value_out_of_range,
              "only the distances of one closed curve have a sign; let from be "
              "curve:closed;... and nothing else",
              "signed");
}

// Ascending, each once.
Result<void> check_levels(std::vector<double>& levels, const std::string& parameter) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (levels[i] < 0) {
      return fail(ErrorCode::value_out_of_range, "a distance is not negative",
                  parameter + "[" + std::to_string(i) + "]");
    }
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return {};
}

Result<void> read_levels(Parameters& parameters, IsolinesRequest& request) {
  if (auto few = check_count(parameters.count("levels"), kMaxLevels, "levels"); !few) return few;
  auto levels = parameters.numbers("levels");
  if (!levels) return fail(std::move(levels.error()));
  const auto step = parameters.number("step");
  if (!step) return fail(step.error());
  const auto count = parameters.whole("count");
  if (!count) return fail(count.error());
  const bool by_levels = !levels->empty();
  if (!by_levels && !*step && !*count) {
    return fail(InputCode::bad_syntax, "one of levels, step and count is needed", "levels");
  }
  if ((by_levels || *step) && *count) {
    return fail(InputCode::bad_syntax, "only one of levels, step and count", "count");
  }
  if (by_levels && *step) {
    return fail(InputCode::bad_syntax, "only one of levels, step and count", "step");
  }
  if (by_levels) {
    if (auto usable = check_levels(*levels, "levels"); !usable) return usable;
    request.levels = std::move(*levels);
  } else if (*step) {
    if (!(**step > 0)) return fail(ErrorCode::value_out_of_range, "a step is above 0", "step");
    request.levels = IsolinesRequest::Step{**step};
  } else {
    if (**count < 1) return fail(ErrorCode::value_out_of_range, "a count is at least 1", "count");
    if (auto few = check_count(**count, kMaxLevels, "count"); !few) return few;
    request.levels = IsolinesRequest::Count{**count};
  }
  return {};
}

// What sites that are lines cannot do.
Result<void> check_sites(const VoronoiRequest& request) {
  const bool has_lines = std::any_of(request.from.begin(), request.from.end(),
                                     [](const PointRequest& site) { return !site.is_point(); });
  if (has_lines && request.relax > 0) {
    return fail(
        ErrorCode::value_out_of_range,
        "only points move to the middle of their cells; with curves, boundaries or faces in "
        "from, leave relax out",
        "relax");
  }
  if (has_lines && request.part == VoronoiRequest::Part::delaunay) {
    return fail(ErrorCode::value_out_of_range,
                "a triangle between sites has points as its corners; with curves, boundaries or "
                "faces in from, part is cells or bisectors",
                "part");
  }
  return {};
}

// Each column that is a line has a field, as a row has. What such columns have is all computed
// before the first row, and kept until the last.
Result<void> check_line_columns(const TableRequest& request) {
  const std::vector<PointRequest>& columns = request.to.empty() ? request.from : request.to;
  const auto lines = std::count_if(columns.begin(), columns.end(),
                                   [](const PointRequest& column) { return !column.is_point(); });
  const bool is_large = request.stream || request.sparse;
  if (!is_large) {
    if (auto few = check_count(static_cast<std::size_t>(lines), kMaxSources, "to"); !few)
      return few;
  }
  const std::uint64_t entries = request.from.size() * static_cast<std::uint64_t>(lines);
  if (entries <= kMaxLineEntries) return {};
  return fail_limit(ErrorCode::too_large,
                    "too many rows for so many columns that are lines; ask for some rows at a time",
                    kMaxLineEntries, entries, "to");
}

// What else is asked for has been read.
Result<void> read_landmarks(Parameters& parameters, TableRequest& request) {
  const auto landmarks = parameters.whole("landmarks");
  if (!landmarks) return fail(landmarks.error());
  if (!*landmarks) return {};
  const auto refuse = [](const char* why) {
    return fail(ErrorCode::value_out_of_range, why, "landmarks");
  };
  if (**landmarks < kFewestLandmarks) return refuse("at least 8 landmarks make an estimate");
  if (auto ok = check_count(**landmarks, kMaxLandmarks, "landmarks"); !ok) return ok;
  if (!request.stream || request.sparse) {
    return refuse(
        "estimates pay for tables of thousands, which go out row after row: set stream, "
        "and not sparse");
  }
  if (request.max) return refuse("what is near is never estimated; leave max or landmarks out");
  if (asks_for_costs(parameters)) {
    return refuse("lengths can be estimated, costs cannot; leave landmarks out");
  }
  if (request.method.options.bound == Bound::upper || request.method.options.error_at_most) {
    return refuse("an estimate keeps no bound; leave bound, tolerance or landmarks out");
  }
  const auto is_point = [](const PointRequest& row) { return row.is_point(); };
  if (!std::all_of(request.from.begin(), request.from.end(), is_point) ||
      !std::all_of(request.to.begin(), request.to.end(), is_point)) {
    return refuse("distances of lines are not estimated; leave landmarks out");
  }
  if (auto ok = check_no_offset(request.from); !ok) return ok;
  request.landmarks = **landmarks;
  return {};
}

}  // namespace

std::string_view name_of(ExtentRequest::Of of) {
  return kExtentNames[static_cast<std::size_t>(of)];
}

std::string_view name_of(LoopRequest::Start start) {
  return start == LoopRequest::Start::plane ? "plane" : kLoopNames[static_cast<std::size_t>(start)];
}

Result<void> parse_request(Parameters& parameters, DistanceRequest& request) {
  if (auto ok = read_sources(parameters, request.from); !ok) return ok;
  if (request.from.empty()) return missing("from");
  if (auto ok = read_points(parameters, "at", kMaxPoints, request.at); !ok) return ok;
  if (auto ok = read_method(parameters, Purpose::distances, request.method); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, request.from); !ok) return ok;
  if (auto ok = read_max(parameters, request.max); !ok) return ok;
  const auto labels = parameters.flag("labels");
  if (!labels) return fail(labels.error());
  request.labels = labels->value_or(false);
  const auto is_signed = parameters.flag("signed");
  if (!is_signed) return fail(is_signed.error());
  request.is_signed = is_signed->value_or(false);
  return request.is_signed ? check_has_sides(request.from) : Result<void>();
}

Result<void> parse_request(Parameters& parameters, PathRequest& request) {
  auto from = parameters.source("from");
  if (!from) return fail(std::move(from.error()));
  request.from = std::move(*from);
  if (auto ok = check_no_offset({request.from}); !ok) return ok;
  if (auto ok = read_points(parameters, "via", kMaxVia, request.via); !ok) return ok;
  if (auto ok = read_point(parameters, "to", request.to); !ok) return ok;
  if (auto ok = read_method(parameters, Purpose::paths, request.method); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, {request.from}); !ok) return ok;
  if (auto ok = read_refine(parameters, request.refine); !ok) return ok;
  if (!asks_for_costs(parameters) || request.refine == Refine::none) return {};
  if (parameters.count("refine") > 0) {
    return fail(ErrorCode::value_out_of_range,
                "the cheapest way is not made the shortest; leave refine out", "refine");
  }
  request.refine = Refine::none;
  return {};
}

Result<void> parse_request(Parameters& parameters, TableRequest& request) {
  const auto stream = parameters.flag("stream");
  if (!stream) return fail(stream.error());
  request.stream = stream->value_or(false);
  const auto sparse = parameters.flag("sparse");
  if (!sparse) return fail(sparse.error());
  request.sparse = sparse->value_or(false);
  const auto rows = parameters.text("rows");
  if (!rows) return fail(rows.error());
  const bool is_large = request.stream || request.sparse;
  const std::size_t most = is_large || *rows ? kMaxPoints : kMaxSources;
  if (auto ok = read_rows(parameters, most, request.from); !ok) return ok;
  if (request.from.empty()) return missing("from");
  request.all_rows = request.from.size();
  if (auto ok = read_columns(parameters, kMaxPoints, request.to); !ok) return ok;
  const std::size_t columns = request.to.empty() ? request.from.size() : request.to.size();
  if (*rows) {
    if (auto ok = take_rows(**rows, request); !ok) return ok;
  }
  if (!is_large) {
    if (auto ok = check_count(request.from.size(), kMaxSources, "from"); !ok) return ok;
  }
  if (auto ok = check_count(request.from.size() * columns,
                            is_large ? kMaxStreamedEntries : kMaxTableEntries, "to");
      !ok) {
    return ok;
  }
  if (auto ok = check_line_columns(request); !ok) return ok;
  if (auto ok = read_method(parameters, Purpose::distances, request.method); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, request.from); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, request.to); !ok) return ok;
  if (auto ok = read_max(parameters, request.max); !ok) return ok;
  return read_landmarks(parameters, request);
}

Result<void> parse_request(Parameters& parameters, IsolinesRequest& request) {
  if (auto ok = read_sources(parameters, request.from); !ok) return ok;
  if (request.from.empty()) return missing("from");
  if (auto ok = read_levels(parameters, request); !ok) return ok;
  if (auto ok = read_method(parameters, Purpose::distances, request.method); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, request.from); !ok) return ok;
  return read_max(parameters, request.max);
}

Result<void> parse_request(Parameters& parameters, SamplesRequest& request) {
  const auto count = parameters.whole("count");
  if (!count) return fail(count.error());
  if (!*count) return missing("count");
  if (**count < 1) return fail(ErrorCode::value_out_of_range, "a count is at least 1", "count");
  if (auto ok = check_count(**count, kMaxSamples, "count"); !ok) return ok;
  request.count = **count;
  if (auto ok = read_sources(parameters, request.from); !ok) return ok;
  if (auto ok = read_method(parameters, Purpose::distances, request.method); !ok) return ok;
  return check_costs_from_points(parameters, request.from);
}

Result<void> parse_request(Parameters& parameters, MeasureRequest& request) {
  if (auto ok = read_sources(parameters, request.from); !ok) return ok;
  if (request.from.empty()) return missing("from");
  if (auto few = check_count(parameters.count("radii"), kMaxRadii, "radii"); !few) return few;
  auto radii = parameters.numbers("radii");
  if (!radii) return fail(std::move(radii.error()));
  if (auto ok = read_method(parameters, Purpose::distances, request.method); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, request.from); !ok) return ok;
  if (auto ok = read_max(parameters, request.max); !ok) return ok;
  for (std::size_t i = 0; request.max && i < radii->size(); ++i) {
    if ((*radii)[i] <= *request.max) continue;
    return fail(ErrorCode::value_out_of_range, "the distances end before this, at max",
                "radii[" + std::to_string(i) + "]");
  }
  if (auto usable = check_levels(*radii, "radii"); !usable) return usable;
  request.radii = std::move(*radii);
  return {};
}

Result<void> parse_request(Parameters& parameters, ExtentRequest& request) {
  const auto of = parameters.text("of");
  if (!of) return fail(of.error());
  if (!*of) return missing("of");
  const auto name = std::find(kExtentNames.begin(), kExtentNames.end(), **of);
  if (name == kExtentNames.end()) {
    return fail(InputCode::bad_syntax, "of is diameter, center, median, mean or means", "of");
  }
  request.of = static_cast<ExtentRequest::Of>(name - kExtentNames.begin());
  const auto fields = parameters.whole("fields");
  if (!fields) return fail(fields.error());
  request.fields = fields->value_or(request.fields);
  if (request.fields < 1) {
    return fail(ErrorCode::value_out_of_range, "there is at least one field", "fields");
  }
  if (auto ok = check_count(request.fields, kMaxFields, "fields"); !ok) return ok;
  return read_method(parameters, Purpose::distances, request.method);
}

Result<void> parse_request(Parameters& parameters, VoronoiRequest& request) {
  if (auto ok = read_sources(parameters, request.from); !ok) return ok;
  if (request.from.empty()) return missing("from");
  const auto relax = parameters.whole("relax");
  if (!relax) return fail(relax.error());
  request.relax = relax->value_or(0);
  if (auto ok = check_count(request.relax, kMaxRelax, "relax"); !ok) return ok;
  const auto part = parameters.text("part");
  if (!part) return fail(part.error());
  if (*part) {
    const auto name = std::find(kVoronoiParts.begin(), kVoronoiParts.end(), **part);
    if (name == kVoronoiParts.end()) {
      return fail(InputCode::bad_syntax, "part is cells, bisectors or delaunay", "part");
    }
    request.part = static_cast<VoronoiRequest::Part>(name - kVoronoiParts.begin());
  }
  if (auto ok = read_method(parameters, Purpose::distances, request.method); !ok) return ok;
  if (auto ok = check_costs_from_points(parameters, request.from); !ok) return ok;
  return check_sites(request);
}

Result<void> parse_request(Parameters& parameters, TraceRequest& request) {
  if (auto ok = read_point(parameters, "from", request.from); !ok) return ok;
  const auto direction = parameters.vector("direction");
  if (!direction) return fail(direction.error());
  const auto angle = parameters.number("angle");
  if (!angle) return fail(angle.error());
  if (!*direction && !*angle) {
    return fail(InputCode::bad_syntax, "one of direction and angle is needed", "direction");
  }
  if (*direction && *angle) {
    return fail(InputCode::bad_syntax, "only one of direction and angle", "angle");
  }
  if (*direction) {
    request.ahead = **direction;
  } else {
    request.ahead = **angle;
  }
  const auto length = parameters.number("length");
  if (!length) return fail(length.error());
  if (!*length) return missing("length");
  if (!(**length >= 0)) {
    return fail(ErrorCode::value_out_of_range, "a length is not negative", "length");
  }
  request.length = **length;
  return {};
}

Result<void> parse_request(Parameters& parameters, LoopRequest& request) {
  const auto start = read_start(parameters);
  if (!start) return fail(start.error());
  request.start = *start;
  if (*start == LoopRequest::Start::plane) return read_plane(parameters, request);
  if (parameters.count("normal") > 0) {
    return fail(InputCode::unknown_parameter, "only a plane has this, with at", "normal");
  }
  const bool is_through = *start == LoopRequest::Start::through;
  if (is_through && parameters.count("hull") > 0) {
    return fail(InputCode::unknown_parameter,
                "only a plane has this: with at and normal, or with three points around", "hull");
  }
  const char* const name = is_through ? "through" : "around";
  if (auto ok = read_points(parameters, name, kMaxLoopPoints, request.points); !ok) return ok;
  const std::size_t least = is_through ? 2 : 3;
  if (request.points.size() < least) {
    return fail(ErrorCode::value_out_of_range,
                "a loop " + std::string(name) + " points has " + std::to_string(least) +
                    " of them at least",
                name);
  }
  if (!is_through) {
    if (auto ok = read_hull(parameters, request); !ok) return ok;
    if (request.hull && request.points.size() > least) {
      return fail(ErrorCode::value_out_of_range,
                  "with hull, three points say the plane that a tape lies in", name);
    }
    if (request.hull) return {};
  }
  return read_method(parameters, Purpose::paths, request.method);
}

Result<void> parse_request(Parameters& parameters, LogmapRequest& request) {
  if (auto ok = read_point(parameters, "from", request.from); !ok) return ok;
  const auto angle = parameters.number("angle");
  if (!angle) return fail(angle.error());
  request.angle = angle->value_or(0);
  const auto radius = parameters.number("radius");
  if (!radius) return fail(radius.error());
  if (*radius && !(**radius > 0)) {
    return fail(ErrorCode::value_out_of_range, "a radius is above 0", "radius");
  }
  request.radius = *radius;
  const auto transport = parameters.flag("transport");
  if (!transport) return fail(transport.error());
  request.transport = transport->value_or(false);
  return read_method(parameters, Purpose::paths, request.method);
}

Result<void> parse_request(Parameters& parameters, NearestRequest& request) {
  if (auto ok = read_points(parameters, "point", kMaxPoints, request.points); !ok) return ok;
  if (request.points.empty()) return missing("point");
  return {};
}

}  // namespace geodesic::proto
