// The JSON of places: cells, maps and closest points.
#include <string>
#include <utility>

#include "proto/replies/reply_json.h"

namespace geodesic::proto {
namespace {

// Arrays of numbers, after another member.
template <class Tuples>
void append_tuples(std::string& out, const char* name, const Tuples& tuples, int digits,
                   Poll* poll) {
  out.append(",\"").append(name).append("\":[");
  const char* before = "";
  for (const auto& tuple : tuples) {
    if (is_stopped(poll)) break;
    out += std::exchange(before, ",");
    append_numbers(out, tuple, digits);
  }
  out += ']';
}

}  // namespace

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
  append_tuples(out, "coordinates", reply.coordinates, digits, poll);
  if (reply.directions) append_tuples(out, "directions", *reply.directions, digits, poll);
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

}  // namespace geodesic::proto
