// The JSON of what is told of whole fields: distances, isolines, samples, measures, extents.
#include <limits>
#include <string>

#include "proto/replies/reply_json.h"

namespace geodesic::proto {

std::string to_json(const DistanceReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.distances.size() * 25 + 1024);
  append_method(out, reply.method);
  append_unit(out, reply.unit);
  out += ",\"from\":";
  append_points(out, reply.from, digits, poll);
  if (reply.is_signed) out += ",\"signed\":true";
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

}  // namespace geodesic::proto
