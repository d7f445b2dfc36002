#include "server/reply/draw_reply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/polled_fill.h"
#include "proto/encode/glb_drawing.h"
#include "proto/picture/colour_map.h"
#include "proto/picture/picture.h"
#include "server/reply/encode_reply.h"

namespace geodesic::server {
namespace {

using proto::Format;
using proto::GlbPart;

constexpr proto::Colour kGrey{190, 192, 196};  // of what is not reached

Result<HttpResponse> glb_reply(const std::vector<GlbPart>& parts, Poll& poll) {
  const std::vector<std::byte> bytes = proto::encode_glb_parts(parts, &poll);
  if (poll.stopped()) return fail_stopped(poll);
  HttpResponse response;
  response.set_body(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                    std::string(proto::media_type_of(Format::glb)));
  return response;
}

Result<HttpResponse> png_reply(const Mesh& mesh, const proto::PictureContent& content,
                               const proto::PictureOptions& options, const Cancel& cancel,
                               Poll& poll) {
  if (poll.stopped()) return fail_stopped(poll);
  const auto image = proto::draw_picture(mesh, content, options, cancel);
  if (!image) return fail(image.error());
  HttpResponse response;
  response.set_body(proto::encode_png(*image, &poll),
                    std::string(proto::media_type_of(Format::png)));
  if (poll.stopped()) return fail_stopped(poll);
  return response;
}

// Of signed distances the line has the colour in the middle.
proto::Colour colour_of(proto::ColourMap map, double distance, double max, bool is_signed) {
  if (distance == kUnreached) return kGrey;
  const double part = max > 0 ? std::clamp(distance / max, -1.0, 1.0) : 0;
  return proto::colour_at(map, is_signed ? 0.5 + 0.5 * part : part);
}

GlbPart coloured_surface(const Mesh& mesh, const proto::DistanceReply& reply, proto::ColourMap map,
                         Poll& poll) {
  GlbPart part;
  part.name = "distance";
  const double max = reply.max.value_or(0);
  part.positions.reserve(mesh.source_vertex_count());
  part.colours.reserve(mesh.source_vertex_count());
  for (std::uint32_t v = 0; v < mesh.source_vertex_count(); ++v) {
    if (poll.cancelled()) break;
    // One that is not on the surface is in no face. Where it lies must not widen what a viewer
    // makes visible.
    const std::uint32_t vertex = mesh.vertex_of_source()[v];
    part.positions.push_back(mesh.positions()[vertex == kNone ? 0 : vertex]);
    part.colours.push_back(colour_of(map, reply.distances[v], max, reply.is_signed));
  }
  part.indices.reserve(3 * mesh.faces().size());
  for (std::uint32_t f = 0; f < mesh.faces().size(); ++f) {
    if (poll.cancelled()) break;
    for (const std::uint32_t v : mesh.faces()[f]) part.indices.push_back(mesh.source_of_vertex(v));
  }
  return part;
}

// The same of a surface whose faces lines have split, by its own vertices.
GlbPart coloured_surface(const Answered<proto::DistanceReply>& answer, proto::ColourMap map,
                         Poll& poll) {
  const Mesh& mesh = answer.adjacency->mesh();
  const Field& field = *answer.drawn_field;
  const auto* const inside = answer.drawn_inside.get();
  GlbPart part;
  part.name = "distance";
  const double max = answer.reply.max.value_or(0);
  part.positions.reserve(mesh.vertex_count());
  part.colours.reserve(mesh.vertex_count());
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (poll.cancelled()) break;
    part.positions.push_back(mesh.positions()[v]);
    const double d = field.distance[v];
    const bool is_below = inside != nullptr && (*inside)[v] != 0 && d != kUnreached;
    part.colours.push_back(colour_of(map, is_below ? -d : d, max, inside != nullptr));
  }
  part.indices.reserve(3 * mesh.faces().size());
  for (const Triangle& face : mesh.faces()) {
    if (poll.cancelled()) break;
    part.indices.insert(part.indices.end(), face.begin(), face.end());
  }
  return part;
}

std::vector<Vec3> positions_of(const std::vector<proto::PathReplyPoint>& points, Poll& poll) {
  std::vector<Vec3> positions;
  positions.reserve(points.size());
  for (const proto::PathReplyPoint& point : points) {
    if (poll.cancelled()) break;
    positions.push_back(point.xyz);
  }
  return positions;
}

GlbPart line(std::string name, std::vector<Vec3> positions) {
  GlbPart part;
  part.name = std::move(name);
  part.mode = GlbPart::Mode::line_strip;
  // A line of one point is none.
  if (positions.size() > 1) part.positions = std::move(positions);
  return part;
}

// The points of an isoline or a bisector, back to the first if it is closed; of no use if the poll
// says to stop.
template <class Line>
std::vector<Vec3> whole_line(const Line& line, Poll& poll) {
  std::vector<Vec3> points;
  polled_copy(points, std::span(line.points), poll);
  if (line.closed && !poll.stopped()) points.push_back(points.front());
  return points;
}

Result<HttpResponse> draw_line(const Mesh& mesh, const char* name,
                               const std::vector<proto::PathReplyPoint>& points, Vec3 start,
                               std::vector<Vec3> targets, const proto::ReplyFormat& format,
                               const Cancel& cancel) {
  Poll poll(cancel);
  std::vector<Vec3> positions = positions_of(points, poll);
  if (format.format == Format::glb) return glb_reply({line(name, std::move(positions))}, poll);
  proto::PictureContent content;
  if (positions.size() > 1) content.lines.push_back(std::move(positions));
  content.sources = {start};
  content.targets = std::move(targets);
  return png_reply(mesh, content, format.picture, cancel, poll);
}

// So that neighbours, whose numbers are often near each other, differ: multiples of the golden
// section are spread evenly over the circle.
proto::Colour colour_of_cell(proto::ColourMap map, std::size_t cell) {
  constexpr double kGoldenSection = 0.6180339887498949;
  const double turns = kGoldenSection * static_cast<double>(cell);
  return proto::colour_at(map, turns - std::floor(turns));
}

GlbPart delaunay_part(const proto::VoronoiReply& reply) {
  GlbPart part;
  part.name = "delaunay";
  for (const auto& triangle : reply.triangles) {
    part.indices.insert(part.indices.end(), triangle.cells.begin(), triangle.cells.end());
  }
  if (part.indices.empty()) return part;
  for (const auto& cell : reply.cells) part.positions.push_back(cell.site.xyz);
  return part;
}

// Of no use if the poll says to stop.
std::vector<GlbPart> parts_of(const proto::VoronoiReply& reply, proto::ColourMap map, Poll& poll) {
  using Part = proto::VoronoiRequest::Part;
  std::vector<GlbPart> parts;
  if (reply.part == Part::delaunay) {
    parts.push_back(delaunay_part(reply));
  } else if (reply.part == Part::bisectors) {
    for (const Bisector& bisector : reply.bisectors) {
      const auto [a, b] = bisector.sites;
      parts.push_back(line("bisector " + std::to_string(a) + " " + std::to_string(b),
                           whole_line(bisector, poll)));
      parts.back().extras = {{"length", bisector.length}};
      if (poll.cancelled()) break;
    }
  } else {
    for (std::size_t i = 0; i < reply.drawn_cells.size(); ++i) {
      GlbPart part;
      part.name = "cell " + std::to_string(i);
      part.extras = {{"cell", std::uint64_t{i}}, {"area", reply.cells[i].area}};
      polled_copy(part.positions, std::span(reply.drawn_cells[i].corners), poll);
      polled_assign(part.colours, part.positions.size(), colour_of_cell(map, i), poll);
      parts.push_back(std::move(part));
      if (poll.cancelled()) break;
    }
  }
  return parts;
}

}  // namespace

Result<HttpResponse> draw(const Answered<proto::DistanceReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  const Mesh& mesh = answer.adjacency->mesh();
  const proto::DistanceReply& reply = answer.reply;
  Poll poll(cancel);
  Result<HttpResponse> response;
  if (format.format == Format::glb) {
    const proto::ColourMap map = format.picture.colour_map;
    response = glb_reply({answer.drawn_field != nullptr ? coloured_surface(answer, map, poll)
                                                        : coloured_surface(mesh, reply, map, poll)},
                         poll);
  } else {
    std::vector<double> values(mesh.vertex_count());
    for (std::uint32_t v = 0; v < values.size(); ++v) {
      if (poll.cancelled()) break;
      values[v] = answer.drawn_field != nullptr ? answer.drawn_field->distance[v]
                                                : reply.distances[mesh.source_of_vertex(v)];
    }
    proto::PictureContent content;
    content.values = values;
    for (const proto::ResolvedPoint& point : reply.from) {
      // The first point of a curve is no more than its others.
      if (!point.lines) content.sources.push_back(point.xyz);
    }
    response = png_reply(mesh, content, format.picture, cancel, poll);
  }
  if (response && reply.max) response->set_header("Geo-Max", header_number(*reply.max));
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

Result<HttpResponse> draw(const Answered<proto::ExtentReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  return draw(means_as_distances(answer), format, cancel);
}

Result<HttpResponse> draw(const Answered<proto::PathReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  const proto::PathReply& reply = answer.reply;
  std::vector<Vec3> targets{reply.to.xyz};
  for (const proto::ResolvedPoint& point : reply.via) targets.push_back(point.xyz);
  auto response = draw_line(answer.adjacency->mesh(), "path", reply.points, reply.from.xyz,
                            std::move(targets), format, cancel);
  if (response && reply.reachable) response->set_header("Geo-Length", header_number(reply.length));
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

Result<HttpResponse> draw(const Answered<proto::TraceReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  const proto::TraceReply& reply = answer.reply;
  auto response = draw_line(answer.adjacency->mesh(), "trace", reply.points, reply.from.xyz,
                            {reply.to.xyz}, format, cancel);
  if (response) response->set_header("Geo-Length", header_number(reply.length));
  return response;
}

Result<HttpResponse> draw(const Answered<proto::LoopReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  const proto::LoopReply& reply = answer.reply;
  std::vector<Vec3> targets;
  for (std::size_t i = 1; i < reply.asked.size(); ++i) targets.push_back(reply.asked[i].xyz);
  auto response = draw_line(answer.adjacency->mesh(), "loop", reply.points, reply.asked.front().xyz,
                            std::move(targets), format, cancel);
  if (response) response->set_header("Geo-Length", header_number(reply.length));
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

Result<HttpResponse> draw(const Answered<proto::LogmapReply>& answer, const proto::ReplyFormat&,
                          const Cancel& cancel) {
  const Mesh& mesh = answer.adjacency->mesh();
  const proto::LogmapReply& reply = answer.reply;
  Poll poll(cancel);
  std::vector<std::uint32_t> place;  // by source vertex, among those of the reply
  polled_assign(place, mesh.source_vertex_count(), kNone, poll);
  GlbPart part;
  part.name = "logmap";
  for (std::uint32_t i = 0; i < reply.vertices.size(); ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    const std::uint32_t v = reply.vertices[i];
    place[v] = i;
    part.positions.push_back(mesh.positions()[mesh.vertex_of_source()[v]]);
    const auto [x, y] = reply.coordinates[i];
    const double size = 2 * (reply.radius > 0 ? reply.radius : 1);
    part.texture.push_back(
        {static_cast<float>(0.5 + x / size), static_cast<float>(0.5 - y / size)});
    if (!reply.directions) continue;
    const auto [dx, dy, dz] = (*reply.directions)[i];
    part.directions.push_back({dx, dy, dz});
  }
  for (const Triangle& face : mesh.faces()) {
    if (poll.cancelled()) return fail_stopped(poll);
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      // A vertex that a line has made has no place, and one beyond a wall is not that of its copy.
      const std::uint32_t source = mesh.source_of_vertex(face[c]);
      const bool is_of_file = source < place.size() && mesh.vertex_of_source()[source] == face[c];
      corners[c] = is_of_file ? place[source] : kNone;
    }
    if (std::find(corners.begin(), corners.end(), kNone) != corners.end()) continue;
    part.indices.insert(part.indices.end(), corners.begin(), corners.end());
  }
  if (part.indices.empty()) part.positions.clear();
  Result<HttpResponse> response = glb_reply({part}, poll);
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

Result<HttpResponse> draw(const Answered<proto::MeasureReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  const proto::MeasureReply& reply = answer.reply;
  Poll poll(cancel);
  std::vector<GlbPart> parts;
  parts.reserve(reply.strips.size());
  for (const Strip& strip : reply.strips) {
    GlbPart part;
    part.name = "strip " + header_number(strip.begin) + " to " + header_number(strip.end);
    part.extras = {{"from", strip.begin}, {"to", strip.end}, {"area", strip.area}};
    // Without a face there is nothing to see, and positions alone would be points.
    if (!strip.faces.empty()) {
      polled_copy(part.positions, std::span(strip.positions), poll);
      part.indices.reserve(3 * strip.faces.size());
      for (const auto& face : strip.faces) {
        if (poll.cancelled()) return fail_stopped(poll);
        part.indices.insert(part.indices.end(), face.begin(), face.end());
      }
      const double middle = (strip.begin + strip.end) / 2 / reply.reach;
      polled_assign(part.colours, part.positions.size(),
                    proto::colour_at(format.picture.colour_map, middle), poll);
    }
    if (poll.cancelled()) return fail_stopped(poll);
    parts.push_back(std::move(part));
  }
  Result<HttpResponse> response = glb_reply(parts, poll);
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

Result<HttpResponse> draw(const Answered<proto::VoronoiReply>& answer,
                          const proto::ReplyFormat& format, const Cancel& cancel) {
  const proto::VoronoiReply& reply = answer.reply;
  Poll poll(cancel);
  Result<HttpResponse> response;
  if (format.format == Format::png) {
    proto::PictureContent content;
    for (std::size_t i = 0; i < reply.drawn_cells.size(); ++i) {
      const auto& cell = reply.drawn_cells[i];
      content.patches.push_back(
          {cell.corners, cell.faces, colour_of_cell(format.picture.colour_map, i)});
    }
    for (const Bisector& bisector : reply.bisectors) {
      content.lines.push_back(whole_line(bisector, poll));
    }
    for (const auto& cell : reply.cells) content.sources.push_back(cell.site.xyz);
    response = png_reply(answer.adjacency->mesh(), content, format.picture, cancel, poll);
  } else {
    response = glb_reply(parts_of(reply, format.picture.colour_map, poll), poll);
  }
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

Result<HttpResponse> draw(const Answered<proto::IsolinesReply>& answer, const proto::ReplyFormat&,
                          const Cancel& cancel) {
  Poll poll(cancel);
  std::vector<GlbPart> parts;
  parts.reserve(answer.reply.isolines.size());
  for (const Isoline& isoline : answer.reply.isolines) {
    parts.push_back(line("level " + header_number(isoline.level), whole_line(isoline, poll)));
    if (poll.cancelled()) return fail_stopped(poll);
  }
  Result<HttpResponse> response = glb_reply(parts, poll);
  if (response) add_cache_header(*response, answer.cache_hit);
  return response;
}

}  // namespace geodesic::server
