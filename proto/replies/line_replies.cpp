// The JSON of lines on the surface: paths, traces and loops.
#include <limits>
#include <string>

#include "proto/replies/reply_json.h"

namespace geodesic::proto {
namespace {

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
    if (reply.is_hull) out += ",\"hull\":true";
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

}  // namespace geodesic::proto
