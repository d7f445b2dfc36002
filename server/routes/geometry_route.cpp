// The route of a mesh's geometry.
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "proto/encode/encode_geometry.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/parameters.h"
#include "proto/wire/reply_format.h"
#include "server/http/entity_tag.h"
#include "server/routes/call.h"
#include "server/routes/engine_digest.h"
#include "server/routes/routes.h"

namespace geodesic::server {

HttpResponse Routes::mesh_geometry(Call& call) {
  // Other replies have numbers to round and colours to choose.
  for (const char* name : {"precision", "colormap"}) {
    if (call.request.parameter(name) == nullptr) continue;
    return call.problem(
        Error{InputCode::unknown_parameter, "this call has no such parameter", name, {}, {}});
  }
  auto parameters = proto::Parameters::from_query(call.request.query);
  const auto format =
      proto::parse_format(parameters, call.request.header("Accept"), proto::kGeometryFormats);
  if (!format) return call.problem(format.error());
  if (const auto known = parameters.check_all_known(); !known) return call.problem(known.error());
  // An id names bytes, and this follows from them and from how they are read.
  const std::string tag = entity_tag(call.id + '\0' + std::string(engine_digest()) + '\0' +
                                     std::string(proto::name_of(format->format)));
  auto response = has_already(call.request, tag) && catalog_.use(call.id)
                      ? Result<HttpResponse>(not_modified(tag))
                      : geometry_reply(call, format->format, tag);
  if (!response) return call.problem(response.error());
  response->set_header("Cache-Control", access_.audience() + ", max-age=31536000, immutable");
  response->set_header("Vary", "Accept");
  return std::move(*response);
}

// Made in a compute slot, once for all who take it at the same time.
Result<HttpResponse> Routes::geometry_reply(const Call& call, proto::Format format,
                                            const std::string& tag) {
  auto body = catalog_.use(call.id) ? geometries_.find(tag) : nullptr;
  if (!body) {
    const auto adjacency = catalog_.adjacency(call.id, call.request.caller);
    if (!adjacency) return fail(adjacency.error());
    const Mesh& mesh = (*adjacency)->mesh();
    auto made = queries_.in_slot(
        [&](const Cancel& cancel) -> Result<std::shared_ptr<const ChargedBody>> {
          if (auto others = geometries_.find(tag)) return others;
          auto reserved =
              reply_budget_.reserve(proto::memory_of_geometry(mesh), call.request.caller.client);
          if (!reserved) return fail(std::move(reserved.error()));
          Poll poll(cancel);
          auto bytes = format == proto::Format::frame ? proto::geometry_frame(call.id, mesh, poll)
                                                      : proto::geometry_glb(mesh, poll);
          if (!bytes) return fail(std::move(bytes.error()));
          (*reserved)->shrink(bytes->size());
          auto whole = std::make_shared<const ChargedBody>(
              ChargedBody{std::move(*bytes), std::move(*reserved)});
          geometries_.add(tag, whole);
          return whole;
        },
        call.request.caller);
    if (!made) return fail(std::move(made.error()));
    body = std::move(*made);
  }
  HttpResponse response;
  response.content_type = proto::media_type_of(format);
  response.body = std::shared_ptr<const std::string>(body, &body->bytes);
  response.reserved = std::move(body);
  response.set_header("ETag", tag);
  return response;
}

}  // namespace geodesic::server
