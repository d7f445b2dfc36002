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

std::string as_text(double value) {
  std::string text;
  proto::append_number(text, value);
  return text;
}

void add_cache_headers(HttpResponse& response, bool hit) {
  response.set_header("Geo-Cache", hit ? "hit" : "miss");
  response.set_header("Vary", "Accept");
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
  const proto::DistanceReply& reply = answer.reply;
  HttpResponse response;
  if (format.format == proto::Format::json) {
    response = json_reply(proto::to_json(reply, format.precision));
  } else {
    response = binary_reply(reply.distances, std::to_string(reply.distances.size()), format.format);
    if (reply.max) response.set_header("Geo-Max", as_text(*reply.max));
  }
  add_cache_headers(response, answer.cache_hit);
  return response;
}

HttpResponse encode(const Answered<proto::PathReply>& answer, const proto::ReplyFormat& format) {
  const proto::PathReply& reply = answer.reply;
  HttpResponse response;
  if (format.format == proto::Format::json) {
    response = json_reply(proto::to_json(reply, format.precision));
  } else {
    std::vector<double> coordinates;
    coordinates.reserve(3 * reply.points.size());
    for (const proto::PathReplyPoint& point : reply.points) {
      coordinates.insert(coordinates.end(), {point.xyz.x, point.xyz.y, point.xyz.z});
    }
    response = binary_reply(coordinates, std::to_string(reply.points.size()) + ",3", format.format);
    if (reply.reachable) response.set_header("Geo-Length", as_text(reply.length));
  }
  add_cache_headers(response, answer.cache_hit);
  return response;
}

Result<HttpResponse> encode(const proto::NearestReply& reply, const proto::ReplyFormat& format) {
  if (format.format != proto::Format::json) {
    return fail(ErrorCode::not_acceptable, "resolved points are offered as application/json",
                "format");
  }
  return json_reply(proto::to_json(reply, format.precision));
}

}  // namespace geodesic::server
