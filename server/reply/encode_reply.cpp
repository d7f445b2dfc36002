#include "server/reply/encode_reply.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/encode/npz.h"
#include "proto/wire/array_formats.h"
#include "proto/wire/number.h"

namespace geodesic::server {
namespace {

using proto::Array;
using proto::Format;
using proto::NumberType;

using Shape = std::vector<std::uint64_t>;

// One array of numbers, and how a client reads it.
struct Numbers {
  std::vector<double> values;
  Shape shape;
  std::optional<double> max = {};  // the greatest finite one
  Bound bound = Bound::none;       // upper: rounded up
};

std::string as_text(const Shape& shape) {
  std::string text;
  for (const std::uint64_t side : shape) {
    if (!text.empty()) text += ',';
    text += std::to_string(side);
  }
  return text;
}

std::string bytes_of(const Numbers& numbers, NumberType type, Poll& poll) {
  if (type == NumberType::f32) return proto::f32_bytes(numbers.values, numbers.bound, &poll);
  if (type == NumberType::u16) {
    return proto::u16_bytes(numbers.values, numbers.max.value_or(0), numbers.bound, &poll);
  }
  return proto::f64_bytes(numbers.values, &poll);
}

HttpResponse array_reply(const Numbers& numbers, Format format, Poll& poll) {
  const NumberType type = format == Format::f32   ? NumberType::f32
                          : format == Format::u16 ? NumberType::u16
                                                  : NumberType::f64;
  std::string bytes = bytes_of(numbers, type, poll);
  if (format == Format::npy) {
    bytes = proto::npy(Array{"", type, numbers.shape, std::move(bytes)});
  }
  HttpResponse response;
  response.set_body(std::move(bytes), std::string(proto::media_type_of(format)));
  response.set_header("Geo-Dtype", std::string(proto::dtype_of(type)));
  response.set_header("Geo-Shape", as_text(numbers.shape));
  if (numbers.max) response.set_header("Geo-Max", header_number(*numbers.max));
  return response;
}

// The arrays, and a reply that has them no more, less what is left of them in its JSON.
template <class Reply>
HttpResponse frame_reply(const Reply& rest, std::initializer_list<const char*> taken,
                         const std::vector<Array>& arrays, Poll& poll) {
  const std::string text = proto::to_json(rest, 0, &poll);
  if (poll.stopped()) return {};
  auto about = nlohmann::ordered_json::parse(text);
  for (const char* const name : taken) about.erase(name);
  HttpResponse response;
  response.set_body(proto::frame(about, arrays), std::string(proto::media_type_of(Format::frame)));
  return response;
}

template <std::size_t Width>
Numbers as_rows(const std::vector<std::array<double, Width>>& rows, Poll& poll) {
  Numbers numbers{{}, {rows.size(), Width}};
  numbers.values.reserve(Width * rows.size());
  for (const std::array<double, Width>& row : rows) {
    if (poll.cancelled()) break;
    numbers.values.insert(numbers.values.end(), row.begin(), row.end());
  }
  return numbers;
}

Array f64_array(const char* name, const Numbers& numbers, Poll& poll) {
  return {name, NumberType::f64, numbers.shape, proto::f64_bytes(numbers.values, &poll)};
}

Array u32_array(const char* name, const std::vector<std::uint32_t>& values, Poll& poll) {
  return {name, NumberType::u32, {values.size()}, proto::u32_bytes(values, &poll)};
}

// The faces and weights of points: where they are on the surface.
std::vector<Array> point_arrays(const std::vector<proto::PathReplyPoint>& points,
                                const Numbers& coordinates, Poll& poll) {
  std::vector<std::uint32_t> faces;
  Numbers weights{{}, {points.size(), 3}};
  for (const proto::PathReplyPoint& point : points) {
    if (poll.cancelled()) break;
    faces.push_back(point.face ? static_cast<std::uint32_t>(*point.face) : kNone);
    weights.values.insert(weights.values.end(), point.bary.begin(), point.bary.end());
  }
  return {f64_array("points", coordinates, poll), u32_array("faces", faces, poll),
          f64_array("bary", weights, poll)};
}

// A sparse table as arrays.
HttpResponse encode_sparse(proto::TableReply& reply, const proto::ReplyFormat& format, Poll& poll) {
  const Shape shape{reply.rows.size(), reply.columns.size()};
  HttpResponse response;
  if (format.format == Format::npz) {
    response.set_body(proto::npz(*reply.sparse, {shape[0], shape[1]}),
                      std::string(proto::media_type_of(format.format)));
  } else {
    const std::uint64_t count = reply.sparse->count();
    proto::SparseEntries entries = std::exchange(*reply.sparse, {});
    const std::vector<Array> arrays{
        {"data", NumberType::f64, {count}, std::move(entries.distances)},
        {"indices", NumberType::u32, {count}, std::move(entries.columns)},
        {"indptr",
         NumberType::u32,
         {entries.begins.size()},
         proto::u32_bytes(entries.begins, &poll)}};
    response = frame_reply(reply, {"data", "indices", "indptr"}, arrays, poll);
  }
  response.set_header("Geo-Shape", as_text(shape));
  return response;
}

template <class Reply>
HttpResponse encode_as_json(const Reply& reply, const proto::ReplyFormat& format, Poll& poll) {
  return json_reply(proto::to_json(reply, format.precision, &poll));
}

// What was encoded, unless it was cut short.
Result<HttpResponse> whole(HttpResponse response, std::optional<bool> hit, const Poll& poll) {
  if (poll.stopped()) return fail_stopped(poll);
  add_cache_header(response, hit);
  return response;
}

// A reply with points along a line and their length.
template <class Reply>
HttpResponse encode_line(Reply reply, const proto::ReplyFormat& format, bool has_length,
                         Poll& poll) {
  if (format.format == Format::json) return encode_as_json(reply, format, poll);
  Numbers coordinates{{}, {reply.points.size(), 3}};
  coordinates.values.reserve(3 * reply.points.size());
  for (const proto::PathReplyPoint& point : reply.points) {
    if (poll.cancelled()) break;
    coordinates.values.insert(coordinates.values.end(), {point.xyz.x, point.xyz.y, point.xyz.z});
  }
  HttpResponse response;
  if (format.format == Format::frame) {
    const auto arrays = point_arrays(std::exchange(reply.points, {}), coordinates, poll);
    response = frame_reply(reply, {"points"}, arrays, poll);
  } else {
    response = array_reply(coordinates, format.format, poll);
  }
  if (has_length) response.set_header("Geo-Length", header_number(reply.length));
  return response;
}

// Of replies that are JSON and nothing else.
template <class Reply>
Result<HttpResponse> json_alone(const Answered<Reply>& answer, const proto::ReplyFormat& format,
                                const Cancel& cancel) {
  Poll poll(cancel);
  return whole(encode_as_json(answer.reply, format, poll), answer.cache_hit, poll);
}

}  // namespace

std::string header_number(double value) {
  std::string text;
  proto::append_number(text, value);
  return text;
}

void add_cache_header(HttpResponse& response, std::optional<bool> hit) {
  if (hit) response.set_header("Geo-Cache", *hit ? "hit" : "miss");
}

Answered<proto::DistanceReply> means_as_distances(const Answered<proto::ExtentReply>& answer) {
  Answered<proto::DistanceReply> drawn;
  drawn.adjacency = answer.adjacency;
  drawn.upload = answer.upload;
  drawn.drawn_field = answer.drawn_field;
  drawn.reply.mesh = answer.reply.mesh;
  drawn.reply.method = answer.reply.method;
  drawn.reply.distances = answer.reply.means;
  for (const double d : drawn.reply.distances) {
    if (d == kUnreached) continue;
    ++drawn.reply.reached;
    drawn.reply.max = std::max(drawn.reply.max.value_or(0), d);
  }
  return drawn;
}

HttpResponse json_reply(std::string json, int status) {
  HttpResponse response;
  response.status = status;
  response.set_body(std::move(json), "application/json");
  return response;
}

Result<HttpResponse> encode(Answered<proto::DistanceReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  Poll poll(cancel);
  proto::DistanceReply& reply = answer.reply;
  if (format.format == Format::json) {
    return whole(encode_as_json(reply, format, poll), answer.cache_hit, poll);
  }
  Numbers distances{{}, {reply.distances.size()}, reply.max, reply.bound};
  distances.values = std::exchange(reply.distances, {});
  if (format.format != Format::frame) {
    return whole(array_reply(distances, format.format, poll), answer.cache_hit, poll);
  }
  // Beside an array of doubles, the greatest of which it is to be.
  reply.short_digits = false;
  std::vector<Array> arrays{f64_array("distances", distances, poll)};
  if (reply.labels) arrays.push_back(u32_array("labels", *std::exchange(reply.labels, {}), poll));
  return whole(frame_reply(reply, {"count", "distances"}, arrays, poll), answer.cache_hit, poll);
}

Result<HttpResponse> encode(Answered<proto::PathReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  Poll poll(cancel);
  const bool reachable = answer.reply.reachable;
  return whole(encode_line(std::move(answer.reply), format, reachable, poll), answer.cache_hit,
               poll);
}

Result<HttpResponse> encode(Answered<proto::TraceReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  Poll poll(cancel);
  return whole(encode_line(std::move(answer.reply), format, true, poll), answer.cache_hit, poll);
}

Result<HttpResponse> encode(Answered<proto::TableReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  Poll poll(cancel);
  proto::TableReply& reply = answer.reply;
  if (format.format == Format::json) {
    return whole(encode_as_json(reply, format, poll), answer.cache_hit, poll);
  }
  if (reply.sparse) return whole(encode_sparse(reply, format, poll), answer.cache_hit, poll);
  Numbers distances{std::exchange(reply.distances, {}), {reply.rows.size(), reply.columns.size()}};
  distances.bound = reply.bound;
  for (const double d : distances.values) {
    if (poll.cancelled()) break;
    if (d != kUnreached) distances.max = std::max(distances.max.value_or(0), d);
  }
  HttpResponse response =
      format.format == Format::frame
          ? frame_reply(reply, {"distances"}, {f64_array("distances", distances, poll)}, poll)
          : array_reply(distances, format.format, poll);
  return whole(std::move(response), answer.cache_hit, poll);
}

Result<HttpResponse> encode(Answered<proto::LoopReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  Poll poll(cancel);
  return whole(encode_line(std::move(answer.reply), format, true, poll), answer.cache_hit, poll);
}

Result<HttpResponse> encode(Answered<proto::LogmapReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  Poll poll(cancel);
  proto::LogmapReply& reply = answer.reply;
  if (format.format == Format::json) {
    return whole(encode_as_json(reply, format, poll), answer.cache_hit, poll);
  }
  const std::uint64_t count = reply.vertices.size();
  const Numbers coordinates = as_rows(std::exchange(reply.coordinates, {}), poll);
  std::optional<Numbers> directions;
  if (reply.directions) directions = as_rows(*std::exchange(reply.directions, {}), poll);
  std::vector<Array> arrays{u32_array("vertices", std::exchange(reply.vertices, {}), poll)};
  arrays.push_back(f64_array("distances", {std::exchange(reply.distances, {}), {count}}, poll));
  arrays.push_back(f64_array("angles", {std::exchange(reply.angles, {}), {count}}, poll));
  arrays.push_back(u32_array("straight", std::exchange(reply.straight, {}), poll));
  arrays.push_back(f64_array("coordinates", coordinates, poll));
  if (directions) arrays.push_back(f64_array("directions", *directions, poll));
  return whole(frame_reply(reply, {"vertices", "distances", "angles", "straight", "coordinates"},
                           arrays, poll),
               answer.cache_hit, poll);
}

Result<HttpResponse> encode(Answered<proto::IsolinesReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  return json_alone(answer, format, cancel);
}

Result<HttpResponse> encode(Answered<proto::SamplesReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  return json_alone(answer, format, cancel);
}

Result<HttpResponse> encode(Answered<proto::MeasureReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  return json_alone(answer, format, cancel);
}

Result<HttpResponse> encode(Answered<proto::ExtentReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  if (format.format == Format::json) return json_alone(answer, format, cancel);
  if (format.format != Format::frame) return encode(means_as_distances(answer), format, cancel);
  Poll poll(cancel);
  proto::ExtentReply& reply = answer.reply;
  const std::uint64_t count = reply.means.size();
  std::vector<Array> arrays{f64_array("means", {std::exchange(reply.means, {}), {count}}, poll)};
  arrays.push_back(f64_array("margins", {std::exchange(reply.margins, {}), {count}}, poll));
  return whole(frame_reply(reply, {"means", "margins"}, arrays, poll), answer.cache_hit, poll);
}

Result<HttpResponse> encode(Answered<proto::VoronoiReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  return json_alone(answer, format, cancel);
}

Result<HttpResponse> encode(Answered<proto::NearestReply> answer, const proto::ReplyFormat& format,
                            const Cancel& cancel) {
  return json_alone(answer, format, cancel);
}

}  // namespace geodesic::server
