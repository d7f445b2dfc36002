// The route of a mesh's geometry.
#include <string_view>
#include <utility>

#include "proto/encode_geometry.h"
#include "proto/parameters.h"
#include "proto/reply_format.h"
#include "server/call.h"
#include "server/routes.h"

namespace geodesic::server {

HttpResponse Routes::mesh_geometry(Call& call) {
  // Other replies have numbers to round and colours to choose.
  for (const char* name : {"precision", "colormap"}) {
    if (call.request.parameter(name) == nullptr) continue;
    return call.problem(
        Error{ErrorCode::unknown_parameter, "this call has no such parameter", name, {}, {}});
  }
  auto parameters = proto::Parameters::from_query(call.request.query);
  const auto format =
      proto::parse_format(parameters, call.request.header("Accept"), proto::kGeometryFormats);
  if (!format) return call.problem(format.error());
  if (const auto known = parameters.check_all_known(); !known) return call.problem(known.error());
  const auto adjacency = catalog_.adjacency(call.id, call.request.caller);
  if (!adjacency) return call.problem(adjacency.error());
  const Mesh& mesh = (*adjacency)->mesh();
  HttpResponse response;
  const std::string type(proto::media_type_of(format->format));
  if (format->format == proto::Format::frame) {
    response.set_body(proto::geometry_frame(call.id, mesh), type);
  } else {
    auto glb = proto::geometry_glb(mesh);
    if (!glb) return call.problem(glb.error());
    response.set_body(std::move(*glb), type);
  }
  // An id names bytes, and this follows from them alone.
  response.set_header("Cache-Control", access_.audience() + ", max-age=31536000, immutable");
  response.set_header("Vary", "Accept");
  return response;
}

}  // namespace geodesic::server
