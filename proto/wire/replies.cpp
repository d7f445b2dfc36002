// Replies are written by hand where they are long runs of numbers: a field of a
// million values as a JSON tree would take twenty times its memory.
#include "proto/wire/replies.h"

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

bool is_stopped(Poll* poll) { return poll != nullptr && poll->cancelled(); }

template <class Values>
void append_numbers(std::string& out, const Values& values, int digits, Poll* poll = nullptr) {
  out += '[';
  bool first = true;
  for (const double value : values) {
    if (is_stopped(poll)) break;
    if (!first) out += ',';
    first = false;
    append_number(out, value, digits);
  }
  out += ']';
}

// After another member.
void append_member(std::string& out, const char* name, double value, int digits = 0) {
  out += ",\"";
  out += name;
  out += "\":";
  append_number(out, value, digits);
}

void append_distances(std::string& out, std::span<const double> distances, int digits,
                      bool short_digits, Bound bound, Poll* poll) {
  out += '[';
  bool first = true;
  for (const double distance : distances) {
    if (is_stopped(poll)) break;
    if (!first) out += ',';
    first = false;
    append_distance(out, distance, digits, short_digits, bound);
  }
  out += ']';
}

// kNone as null.
void append_wholes(std::string& out, std::span<const std::uint32_t> values, Poll* poll) {
  out += '[';
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (is_stopped(poll)) break;
    if (i > 0) out += ',';
    out += values[i] == kNone ? "null" : std::to_string(values[i]);
  }
  out += ']';
}

void append_xyz(std::string& out, Vec3 p, int digits) {
  append_numbers(out, std::array{p.x, p.y, p.z}, digits);
}

void append_whole(std::string& out, const std::optional<std::uint64_t>& value) {
  out += value ? std::to_string(*value) : "null";
}

void append_place(std::string& out, const std::optional<std::uint64_t>& face,
                  const std::array<double, 3>& bary, int digits) {
  out += "\"face\":";
  append_whole(out, face);
  out += ",\"bary\":";
  if (face) {
    append_numbers(out, bary, digits);
  } else {
    out += "null";
  }
}

void append_point(std::string& out, const ResolvedPoint& point, int digits) {
  out += '{';
  if (point.vertex) out += "\"vertex\":" + std::to_string(*point.vertex) + ",";
  append_place(out, point.face, point.bary, digits);
  out += ",\"xyz\":";
  append_xyz(out, point.xyz, digits);
  append_member(out, "snap_distance", point.snap_distance, digits);
  if (point.ray_distance) {
    append_member(out, "ray_distance", *point.ray_distance, digits);
  }
  if (point.lines) {
    out += ",\"kind\":\"" + std::string(point.lines->kind) + "\"";
    append_member(out, "length", point.lines->length, digits);
    out += ",\"pieces\":" + std::to_string(point.lines->pieces);
    if (point.lines->faces > 0) out += ",\"faces\":" + std::to_string(point.lines->faces);
  }
  out += '}';
}

void append_points(std::string& out, const std::vector<ResolvedPoint>& points, int digits,
                   Poll* poll) {
  out += '[';
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_stopped(poll)) break;
    if (i > 0) out += ',';
    append_point(out, points[i], digits);
  }
  out += ']';
}

void append_path_points(std::string& out, const std::vector<PathReplyPoint>& points, int digits,
                        Poll* poll) {
  out += '[';
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_stopped(poll)) break;
    out += i > 0 ? ",{\"xyz\":" : "{\"xyz\":";
    append_xyz(out, points[i].xyz, digits);
    out += ',';
    append_place(out, points[i].face, points[i].bary, digits);
    out += '}';
  }
  out += ']';
}

// Of a line on the surface, after another member.
void append_line(std::string& out, bool closed, double length, const std::vector<Vec3>& points,
                 int digits, Poll* poll) {
  out += closed ? ",\"closed\":true,\"length\":" : ",\"closed\":false,\"length\":";
  append_number(out, length, digits);
  out += ",\"points\":[";
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_stopped(poll)) break;
    if (i > 0) out += ',';
    append_xyz(out, points[i], digits);
  }
  out += ']';
}

// Mesh ids are hexadecimal and method names are ours: neither needs escaping.
std::string opening(const std::string& mesh) { return "{\"mesh\":\"" + mesh + "\""; }

// The sentences are ours, and need no escaping.
void append_warnings(std::string& out, const Warnings& warnings) {
  if (warnings.empty()) return;
  out += ",\"warnings\":[";
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    if (i > 0) out += ',';
    out += '"' + warnings[i] + '"';
  }
  out += ']';
}

void append_method(std::string& out, Method method) {
  out += ",\"method\":\"";
  out += name_of(method);
  out += '"';
}

// In what costs are, where distances are costs.
void append_unit(std::string& out, std::optional<std::string_view> unit) {
  if (!unit) return;
  out += ",\"unit\":\"";
  out += *unit;
  out += '"';
}

void append_path_costs(std::string& out, const PathCosts& costs, bool reachable, int digits,
                       Poll* poll) {
  append_unit(out, costs.unit);
  append_member(out, "cost", reachable ? costs.whole : std::numeric_limits<double>::infinity(),
                digits);
  out += ",\"segments\":[";
  for (std::size_t i = 0; i < costs.costs.size(); ++i) {
    if (is_stopped(poll)) break;
    out += i > 0 ? ",{\"length\":" : "{\"length\":";
    append_number(out, costs.lengths[i], digits);
    append_member(out, "cost", costs.costs[i], digits);
    out += '}';
  }
  out += ']';
}

}  // namespace

std::string to_json(const DistanceReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.distances.size() * 25 + 1024);
  append_method(out, reply.method);
  append_unit(out, reply.unit);
  out += ",\"from\":";
  append_points(out, reply.from, digits, poll);
  if (reply.at) {
    out += ",\"at\":";
    append_points(out, *reply.at, digits, poll);
  }
  out += ",\"count\":" + std::to_string(reply.distances.size());
  out += ",\"reached\":" + std::to_string(reply.reached);
  out += ",\"max\":";
  append_distance(out, reply.max.value_or(std::numeric_limits<double>::infinity()), digits,
                  reply.short_digits, reply.bound);
  out += ",\"farthest\":";
  append_whole(out, reply.farthest);
  out += ",\"distances\":";
  append_distances(out, reply.distances, digits, reply.short_digits, reply.bound, poll);
  if (reply.labels) {
    out += ",\"labels\":";
    append_wholes(out, *reply.labels, poll);
  }
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const PathReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.points.size() * 160 + 1024);
  append_method(out, reply.method);
  out += reply.refine == Refine::shortest ? ",\"refine\":\"shortest\"" : ",\"refine\":\"none\"";
  out += ",\"from\":";
  append_point(out, reply.from, digits);
  out += ",\"via\":";
  append_points(out, reply.via, digits, poll);
  out += ",\"to\":";
  append_point(out, reply.to, digits);
  out += ",\"reachable\":";
  out += reply.reachable ? "true" : "false";
  out += ",\"length\":";
  append_bound(out, reply.reachable ? reply.length : std::numeric_limits<double>::infinity(),
               digits, reply.bound);
  if (reply.costs) append_path_costs(out, *reply.costs, reply.reachable, digits, poll);
  out += ",\"points\":";
  append_path_points(out, reply.points, digits, poll);
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

namespace {

template <class Number>
Number number_at(const std::string& bytes, std::uint64_t i) {
  Number number;
  std::memcpy(&number, bytes.data() + i * sizeof number, sizeof number);
  return number;
}

// The rest of a sparse table.
std::string with_sparse(std::string out, const TableReply& reply, int digits, Poll* poll) {
  const SparseEntries& sparse = *reply.sparse;
  out += ",\"indptr\":";
  append_wholes(out, sparse.begins, poll);
  out += ",\"indices\":[";
  for (std::uint64_t i = 0; i < sparse.count() && !is_stopped(poll); ++i) {
    if (i > 0) out += ',';
    out += std::to_string(number_at<std::uint32_t>(sparse.columns, i));
  }
  out += "],\"data\":[";
  // Without its distances, which then go another way, there are none.
  for (std::uint64_t i = 0; i * sizeof(double) < sparse.distances.size() && !is_stopped(poll);
       ++i) {
    if (i > 0) out += ',';
    append_distance(out, number_at<double>(sparse.distances, i), digits, reply.short_digits,
                    reply.bound);
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

}  // namespace

std::string first_line(const TableReply& reply, std::uint64_t first_row, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"first_row\":" + std::to_string(first_row);
  out += ",\"rows\":" + std::to_string(reply.rows.size());
  out += ",\"columns\":";
  append_points(out, reply.columns, digits, poll);
  append_warnings(out, reply.warnings);
  out += "}\n";
  return out;
}

std::string row_line(const TableReply& reply, std::size_t row, std::uint64_t number,
                     std::span<const double> distances, bool sparse, int digits, Poll* poll) {
  std::string out = "{\"row\":" + std::to_string(number) + ",\"from\":";
  append_point(out, reply.rows[row], digits);
  if (!sparse) {
    out += ",\"distances\":";
    append_distances(out, distances, digits, reply.short_digits, reply.bound, poll);
    out += "}\n";
    return out;
  }
  std::vector<double> reached;
  out += ",\"columns\":[";
  for (std::size_t i = 0; i < distances.size() && !is_stopped(poll); ++i) {
    if (distances[i] == kUnreached) continue;
    if (!reached.empty()) out += ',';
    out += std::to_string(i);
    reached.push_back(distances[i]);
  }
  out += "],\"distances\":";
  append_distances(out, reached, digits, reply.short_digits, reply.bound, poll);
  out += "}\n";
  return out;
}

std::string to_json(const TableReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.distances.size() * 19 + 1024);
  append_method(out, reply.method);
  append_unit(out, reply.unit);
  out += ",\"rows\":";
  append_points(out, reply.rows, digits, poll);
  out += ",\"columns\":";
  append_points(out, reply.columns, digits, poll);
  if (reply.sparse) return with_sparse(std::move(out), reply, digits, poll);
  out += ",\"distances\":[";
  const std::span<const double> all(reply.distances);
  // Without its distances, which then go another way, there is no row.
  const std::size_t rows = all.empty() ? 0 : reply.rows.size();
  for (std::size_t row = 0; row < rows; ++row) {
    if (is_stopped(poll)) break;
    if (row > 0) out += ',';
    append_distances(out, all.subspan(row * reply.columns.size(), reply.columns.size()), digits,
                     reply.short_digits, reply.bound, poll);
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const IsolinesReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  append_unit(out, reply.unit);
  out += ",\"from\":";
  append_points(out, reply.from, digits, poll);
  append_member(out, "max", reply.max.value_or(std::numeric_limits<double>::infinity()), digits);
  out += ",\"levels\":";
  append_numbers(out, reply.levels, digits, poll);
  out += ",\"isolines\":[";
  bool first = true;
  for (const Isoline& line : reply.isolines) {
    if (is_stopped(poll)) break;
    out += first ? "{\"level\":" : ",{\"level\":";
    first = false;
    append_number(out, line.level, digits);
    append_line(out, line.closed, line.length, line.points, digits, poll);
    out += '}';
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const SamplesReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"from\":";
  append_points(out, reply.from, digits, poll);
  out += ",\"samples\":[";
  bool first = true;
  for (const SampleReply& sample : reply.samples) {
    if (is_stopped(poll)) break;
    out += first ? "{\"vertex\":" : ",{\"vertex\":";
    first = false;
    out += std::to_string(sample.vertex) + ",\"xyz\":";
    append_xyz(out, sample.xyz, digits);
    out += ",\"radius\":";
    append_bound(out, sample.radius, digits, reply.bound);
    out += '}';
  }
  out += "],\"covering_radius\":";
  append_bound(out, reply.covering_radius, digits, reply.bound);
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const MeasureReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"from\":";
  append_points(out, reply.from, digits, poll);
  append_member(out, "area", reply.area, digits);
  append_member(out, "mean", reply.mean, digits);
  out += ",\"max\":";
  append_bound(out, reply.max.value_or(std::numeric_limits<double>::infinity()), digits,
               reply.bound);
  out += ",\"farthest\":";
  append_whole(out, reply.farthest);
  out += ",\"discs\":[";
  bool first = true;
  for (const Disc& disc : reply.discs) {
    if (is_stopped(poll)) break;
    out += first ? "{\"radius\":" : ",{\"radius\":";
    first = false;
    append_number(out, disc.radius, digits);
    append_member(out, "area", disc.area, digits);
    append_member(out, "mean", disc.mean, digits);
    append_member(out, "perimeter", disc.perimeter, digits);
    append_member(out, "boundary", disc.boundary, digits);
    out += ",\"lines\":" + std::to_string(disc.lines);
    out += ",\"vertices\":" + std::to_string(disc.vertices);
    out += ",\"euler\":" + std::to_string(disc.euler);
    out += disc.is_whole ? ",\"whole\":true}" : ",\"whole\":false}";
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const ExtentReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"of\":\"";
  out += name_of(reply.of);
  out += '"';
  append_member(out, "value", reply.value, digits);
  append_member(out, "lower", reply.lower, digits);
  append_member(out, "upper", reply.upper, digits);
  append_member(out, "confidence", reply.confidence);
  out += reply.is_exact ? ",\"exact\":true,\"vertices\":[" : ",\"exact\":false,\"vertices\":[";
  bool first = true;
  for (const ExtentReply::Vertex& vertex : reply.vertices) {
    out += first ? "{\"vertex\":" : ",{\"vertex\":";
    first = false;
    out += std::to_string(vertex.vertex) + ",\"xyz\":";
    append_xyz(out, vertex.xyz, digits);
    out += '}';
  }
  out += "],\"fields\":" + std::to_string(reply.fields);
  out += ",\"part_vertices\":" + std::to_string(reply.part_vertices);
  if (reply.of == ExtentRequest::Of::means) {
    out += ",\"means\":";
    append_distances(out, reply.means, digits, false, Bound::none, poll);
    out += ",\"margins\":";
    append_distances(out, reply.margins, digits, false, Bound::none, poll);
  }
  out += '}';
  return out;
}

std::string to_json(const VoronoiReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"from\":";
  append_points(out, reply.from, digits, poll);
  out += ",\"relax\":" + std::to_string(reply.relax);
  out += ",\"cells\":[";
  const char* before = "{\"site\":";
  for (const VoronoiReply::Cell& cell : reply.cells) {
    if (is_stopped(poll)) break;
    out += std::exchange(before, ",{\"site\":");
    append_point(out, cell.site, digits);
    append_member(out, "area", cell.area, digits);
    append_member(out, "perimeter", cell.perimeter, digits);
    append_member(out, "boundary", cell.boundary, digits);
    out += ",\"vertices\":" + std::to_string(cell.vertices) + ",\"centroid\":";
    if (cell.centroid) {
      append_point(out, *cell.centroid, digits);
    } else {
      out += "null";
    }
    out += '}';
  }
  out += "],\"neighbors\":[";
  before = "{\"cells\":";
  for (const NeighbourCells& pair : reply.neighbours) {
    if (is_stopped(poll)) break;
    out += std::exchange(before, ",{\"cells\":");
    append_wholes(out, pair.sites, poll);
    append_member(out, "length", pair.length, digits);
    out += '}';
  }
  out += "],\"bisectors\":[";
  before = "{\"cells\":";
  for (const Bisector& line : reply.bisectors) {
    if (is_stopped(poll)) break;
    out += std::exchange(before, ",{\"cells\":");
    append_wholes(out, line.sites, poll);
    append_line(out, line.closed, line.length, line.points, digits, poll);
    out += '}';
  }
  out += "],\"triangles\":[";
  before = "{\"cells\":";
  for (const VoronoiReply::Triangle& triangle : reply.triangles) {
    if (is_stopped(poll)) break;
    out += std::exchange(before, ",{\"cells\":");
    append_wholes(out, triangle.cells, poll);
    append_member(out, "distance", triangle.distance, digits);
    out += ",\"point\":";
    append_point(out, triangle.point, digits);
    out += '}';
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const TraceReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.points.size() * 160 + 1024);
  out += ",\"from\":";
  append_point(out, reply.from, digits);
  out += ",\"to\":";
  append_point(out, reply.to, digits);
  append_member(out, "length", reply.length, digits);
  out += ",\"end\":\"";
  out += reply.end;
  out += "\",\"direction_at_end\":";
  append_xyz(out, reply.direction_at_end, digits);
  out += ",\"points\":";
  append_path_points(out, reply.points, digits, poll);
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const LoopReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.points.size() * 160 + 1024);
  if (reply.method) append_method(out, *reply.method);
  out += ",\"start\":\"";
  out += name_of(reply.start);
  if (reply.start == LoopRequest::Start::plane) {
    out += "\",\"at\":";
    append_point(out, reply.asked.front(), digits);
    out += ",\"normal\":";
    append_xyz(out, reply.normal.value_or(Vec3{}), digits);
    out += reply.is_hull ? ",\"hull\":true" : ",\"hull\":false";
  } else {
    out += "\",\"";
    out += name_of(reply.start);
    out += "\":";
    append_points(out, reply.asked, digits, poll);
  }
  out += ",\"length\":";
  append_bound(out, reply.length, digits, reply.bound);
  append_member(out, "start_length", reply.start_length, digits);
  out += reply.is_geodesic ? ",\"geodesic\":true" : ",\"geodesic\":false";
  append_member(out, "turn", reply.turn.value_or(std::numeric_limits<double>::infinity()), digits);
  out += ",\"points\":";
  append_path_points(out, reply.points, digits, poll);
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const LogmapReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"from\":";
  append_point(out, reply.from, digits);
  append_member(out, "angle", reply.angle, digits);
  append_member(out, "radius", reply.radius, digits);
  append_member(out, "total_angle", reply.total_angle, digits);
  out += reply.all_round ? ",\"all_round\":true" : ",\"all_round\":false";
  out += ",\"vertices\":";
  append_wholes(out, reply.vertices, poll);
  out += ",\"distances\":";
  append_numbers(out, reply.distances, digits, poll);
  out += ",\"angles\":";
  append_numbers(out, reply.angles, digits, poll);
  out += ",\"straight\":";
  append_wholes(out, reply.straight, poll);
  out += ",\"coordinates\":[";
  for (std::size_t i = 0; i < reply.coordinates.size(); ++i) {
    if (is_stopped(poll)) break;
    if (i > 0) out += ',';
    append_numbers(out, reply.coordinates[i], digits);
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

std::string to_json(const NearestReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out += ",\"points\":";
  append_points(out, reply.points, digits, poll);
  out += '}';
  return out;
}

std::string methods_json() {
  using nlohmann::ordered_json;
  const auto bound = [](const MethodParameter& parameter, double value) {
    return parameter.whole ? ordered_json(static_cast<std::uint64_t>(value)) : ordered_json(value);
  };
  const auto users_of = [](const MethodParameter& parameter) {
    return parameter.serves == Serves::all     ? "all"
           : parameter.serves == Serves::paths ? "paths"
                                               : "distances";
  };
  ordered_json methods = ordered_json::array();
  for (const MethodInfo& info : all_methods()) {
    ordered_json parameters = ordered_json::array();
    for (const MethodParameter& parameter : info.parameters) {
      if (!parameter.choices.empty()) {
        parameters.push_back({{"name", parameter.name},
                              {"type", "choice"},
                              {"choices", parameter.choices},
                              {"default", parameter.choices[std::size_t(parameter.standard)]},
                              {"for", users_of(parameter)},
                              {"meaning", parameter.meaning}});
        continue;
      }
      parameters.push_back({{"name", parameter.name},
                            {"type", parameter.whole ? "integer" : "number"},
                            {"minimum", bound(parameter, parameter.minimum)},
                            {"maximum", bound(parameter, parameter.maximum)},
                            {"default", bound(parameter, parameter.standard)},
                            {"for", users_of(parameter)},
                            {"meaning", parameter.meaning}});
    }
    methods.push_back({{"name", info.name},
                       {"default", info.method == kDefaultMethod},
                       {"about", info.about},
                       {"paper", info.paper},
                       {"exact", info.exact},
                       {"cost", info.cost},
                       {"parameters", std::move(parameters)}});
  }
  return ordered_json{{"methods", std::move(methods)}}.dump();
}

}  // namespace geodesic::proto
