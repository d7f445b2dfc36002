#include "proto/replies/reply_json.h"

#include <array>

#include "proto/wire/methods.h"

namespace geodesic::proto {
namespace {

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

}  // namespace

void append_member(std::string& out, const char* name, double value, int digits) {
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

std::string opening(const std::string& mesh) { return "{\"mesh\":\"" + mesh + "\""; }

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

void append_unit(std::string& out, std::optional<std::string_view> unit) {
  if (!unit) return;
  out += ",\"unit\":\"";
  out += *unit;
  out += '"';
}

}  // namespace geodesic::proto
