#include "server/encode_reply.h"

#include <bit>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "proto/number.h"

namespace geodesic::server {
namespace {

static_assert(std::endian::native == std::endian::little, "binary replies are little-endian");

template <class Number>
std::string packed(const std::vector<double>& values) {
  std::string bytes(values.size() * sizeof(Number), '\0');
  char* out = bytes.data();
  for (const double value : values) {
    const auto number = static_cast<Number>(value);
    std::memcpy(out, &number, sizeof number);
    out += sizeof number;
  }
  return bytes;
}

HttpResponse binary_reply(const std::vector<double>& values, const std::string& shape,
                          proto::Format format) {
  const bool narrow = format == proto::Format::f32;
  HttpResponse response;
  response.set_body(narrow ? packed<float>(values) : packed<double>(values),
                    "application/octet-stream");
  response.set_header("Geo-Dtype", narrow ? "<f4" : "<f8");
  response.set_header("Geo-Shape", shape);
  return response;
}

HttpResponse points_reply(const std::vector<proto::PathReplyPoint>& points, proto::Format format) {
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const proto::PathReplyPoint& point : points) {
    coordinates.insert(coordinates.end(), {point.xyz.x, point.xyz.y, point.xyz.z});
  }
  return binary_reply(coordinates, std::to_string(points.size()) + ",3", format);
}

std::string as_text(double value) {
  std::string text;
  proto::append_number(text, value);
  return text;
}

HttpResponse with_cache_headers(HttpResponse response, std::optional<bool> hit) {
  if (hit) response.set_header("Geo-Cache", *hit ? "hit" : "miss");
  response.set_header("Vary", "Accept");
  return response;
}

template <class Reply>
HttpResponse encode_as_json(const Answered<Reply>& answer, const proto::ReplyFormat& format) {
  return with_cache_headers(json_reply(proto::to_json(answer.reply, format.precision)),
                            answer.cache_hit);
}

}  // namespace

HttpResponse json_reply(std::string json, int status) {
  HttpResponse response;
  response.status = status;
  response.set_body(std::move(json), "application/json");
  return response;
}

HttpResponse encode(const Answered<proto::DistanceReply>& answer,
                    const proto::ReplyFormat& format) {
  if (format.format == proto::Format::json) return encode_as_json(answer, format);
  const proto::DistanceReply& reply = answer.reply;
  HttpResponse response =
      binary_reply(reply.distances, std::to_string(reply.distances.size()), format.format);
  if (reply.max) response.set_header("Geo-Max", as_text(*reply.max));
  return with_cache_headers(std::move(response), answer.cache_hit);
}

HttpResponse encode(const Answered<proto::PathReply>& answer, const proto::ReplyFormat& format) {
  if (format.format == proto::Format::json) return encode_as_json(answer, format);
  const proto::PathReply& reply = answer.reply;
  HttpResponse response = points_reply(reply.points, format.format);
  if (reply.reachable) response.set_header("Geo-Length", as_text(reply.length));
  return with_cache_headers(std::move(response), answer.cache_hit);
}

HttpResponse encode(const Answered<proto::TraceReply>& answer, const proto::ReplyFormat& format) {
  if (format.format == proto::Format::json) return encode_as_json(answer, format);
  HttpResponse response = points_reply(answer.reply.points, format.format);
  response.set_header("Geo-Length", as_text(answer.reply.length));
  return with_cache_headers(std::move(response), answer.cache_hit);
}

HttpResponse encode(const Answered<proto::TableReply>& answer, const proto::ReplyFormat& format) {
  if (format.format == proto::Format::json) return encode_as_json(answer, format);
  const proto::TableReply& reply = answer.reply;
  std::string shape = std::to_string(reply.rows.size());
  shape += ',';
  shape += std::to_string(reply.columns.size());
  return with_cache_headers(binary_reply(reply.distances, shape, format.format), answer.cache_hit);
}

HttpResponse encode(const Answered<proto::IsolinesReply>& answer,
                    const proto::ReplyFormat& format) {
  return encode_as_json(answer, format);
}

HttpResponse encode(const Answered<proto::SamplesReply>& answer, const proto::ReplyFormat& format) {
  return encode_as_json(answer, format);
}

HttpResponse encode(const Answered<proto::NearestReply>& answer, const proto::ReplyFormat& format) {
  return encode_as_json(answer, format);
}

}  // namespace geodesic::server
