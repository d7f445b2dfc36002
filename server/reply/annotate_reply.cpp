#include "server/reply/annotate_reply.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/base/polled_fill.h"
#include "proto/encode/glb_drawing.h"
#include "proto/wire/array_formats.h"
#include "server/reply/annotated_file.h"
#include "server/reply/encode_reply.h"

namespace geodesic::server {
namespace {

using Attributes = std::vector<proto::VertexAttribute>;

// What glTF's floats have for what nothing reaches: no distance is below 0, but of those with a
// sign there are some, so that it is the greatest float there.
constexpr double kNowhere = -1;
constexpr double kNowhereSigned = std::numeric_limits<float>::max();

std::string name_or(const std::string& given, const char* standard) {
  return given.empty() ? standard : given;
}

Attributes distance_attributes(bool has_labels, bool is_signed, const proto::ReplyFormat& format) {
  const char* const standard = is_signed ? "_GEODESIC_SIGNED_DISTANCE" : "_GEODESIC_DISTANCE";
  Attributes attributes{{name_or(format.attribute, standard), 1}};
  if (has_labels) attributes.push_back({name_or(format.label_attribute, "_GEODESIC_SOURCE"), 1});
  return attributes;
}

Attributes logmap_attributes(bool has_directions, const proto::ReplyFormat& format) {
  Attributes attributes{{name_or(format.attribute, "_GEODESIC_LOGMAP"), 3}};
  if (has_directions) attributes.push_back({proto::kDirectionAttribute, 3});
  return attributes;
}

std::string name_of_means(const proto::ReplyFormat& format) {
  return name_or(format.attribute, "_GEODESIC_MEAN_DISTANCE");
}

// What a float can be: glTF has no infinite ones.
double as_finite(double value) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::clamp(value, -kMost, kMost);
}

Result<HttpResponse> file_reply(const UploadedGltf& upload, const Attributes& attributes,
                                const std::vector<std::string>& floats,
                                std::optional<bool> cache_hit, Poll& poll) {
  if (poll.stopped()) return fail_stopped(poll);
  auto file = write_annotated(upload.bytes, upload.annotation, attributes, floats, poll);
  if (!file) return fail(std::move(file.error()));
  const bool is_glb = file->starts_with("glTF");
  HttpResponse response;
  response.set_body(std::move(*file), is_glb ? "model/gltf-binary" : "model/gltf+json");
  add_cache_header(response, cache_hit);
  return response;
}

}  // namespace

Result<Attributes> attributes_of(const proto::DistanceRequest& request,
                                 const proto::ReplyFormat& format) {
  Attributes attributes = distance_attributes(request.labels, request.is_signed, format);
  if (attributes.front().name == attributes.back().name && attributes.size() > 1) {
    return fail(ErrorCode::value_out_of_range, "the distances are called so, too",
                "label_attribute");
  }
  return attributes;
}

Result<Attributes> attributes_of(const proto::LogmapRequest& request,
                                 const proto::ReplyFormat& format) {
  if (request.transport && format.attribute == proto::kDirectionAttribute) {
    return fail(ErrorCode::value_out_of_range, "the directions are called so", "attribute");
  }
  return logmap_attributes(request.transport, format);
}

Result<Attributes> attributes_of(const proto::ExtentRequest& /*request*/,
                                 const proto::ReplyFormat& format) {
  return Attributes{{name_of_means(format), 1}};
}

Result<HttpResponse> annotate(Answered<proto::DistanceReply> answer,
                              const proto::ReplyFormat& format, const Cancel& cancel) {
  Poll poll(cancel);
  proto::DistanceReply& reply = answer.reply;
  const double nowhere = reply.is_signed ? kNowhereSigned : kNowhere;
  for (double& d : reply.distances) {
    if (poll.cancelled()) return fail_stopped(poll);
    d = d == kUnreached ? nowhere : as_finite(d);
  }
  std::vector<std::string> floats{proto::f32_bytes(reply.distances, reply.bound, &poll)};
  if (reply.labels) {
    for (std::size_t i = 0; i < reply.labels->size(); ++i) {
      if (poll.cancelled()) return fail_stopped(poll);
      const std::uint32_t label = (*reply.labels)[i];
      reply.distances[i] = label == kNone ? kNowhere : label;
    }
    floats.push_back(proto::f32_bytes(reply.distances, Bound::none, &poll));
  }
  const Attributes attributes =
      distance_attributes(reply.labels.has_value(), reply.is_signed, format);
  auto response = file_reply(*answer.upload, attributes, floats, answer.cache_hit, poll);
  if (response && reply.max) response->set_header("Geo-Max", header_number(*reply.max));
  return response;
}

Result<HttpResponse> annotate(Answered<proto::ExtentReply> answer, const proto::ReplyFormat& format,
                              const Cancel& cancel) {
  proto::ReplyFormat named = format;
  named.attribute = name_of_means(format);
  return annotate(means_as_distances(answer), named, cancel);
}

Result<HttpResponse> annotate(Answered<proto::LogmapReply> answer, const proto::ReplyFormat& format,
                              const Cancel& cancel) {
  Poll poll(cancel);
  const proto::LogmapReply& reply = answer.reply;
  std::vector<double> values;
  polled_assign(values, std::size_t{3} * answer.adjacency->mesh().source_vertex_count(), 0.0, poll);
  if (poll.stopped()) return fail_stopped(poll);
  for (std::size_t i = 2; i < values.size(); i += 3) {
    if (poll.cancelled()) return fail_stopped(poll);
    values[i] = kNowhere;
  }
  for (std::size_t i = 0; i < reply.vertices.size(); ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    double* const value = &values[std::size_t{3} * reply.vertices[i]];
    value[0] = as_finite(reply.coordinates[i][0]);
    value[1] = as_finite(reply.coordinates[i][1]);
    value[2] = as_finite(reply.distances[i]);
  }
  std::vector<std::string> floats{proto::f32_bytes(values, Bound::none, &poll)};
  if (reply.directions) {
    std::fill(values.begin(), values.end(), 0.0);
    for (std::size_t i = 0; i < reply.vertices.size(); ++i) {
      if (poll.cancelled()) return fail_stopped(poll);
      std::copy_n((*reply.directions)[i].begin(), 3, &values[std::size_t{3} * reply.vertices[i]]);
    }
    floats.push_back(proto::f32_bytes(values, Bound::none, &poll));
  }
  return file_reply(*answer.upload, logmap_attributes(reply.directions.has_value(), format), floats,
                    answer.cache_hit, poll);
}

}  // namespace geodesic::server
