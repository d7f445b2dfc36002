// Answers to HTTP as something to look at: a GLB that any viewer opens, or a PNG.
// It takes time that grows with the mesh and the picture: to be run in a compute slot.
#pragma once

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/replies/replies.h"
#include "proto/wire/reply_format.h"
#include "server/http/message.h"
#include "server/query/field_queries.h"

namespace geodesic::server {

[[nodiscard]] constexpr bool is_drawing(proto::Format format) {
  return format == proto::Format::glb || format == proto::Format::png;
}

// GLB: the whole surface in source-vertex order, coloured by distance. PNG: the same
// with isolines and a scale. Errors here and below: cancelled.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::DistanceReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// The mean distances, in the same way.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::ExtentReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// GLB: the path as a line strip, nothing when there is none. PNG: the path on the
// surface, its start as a disc, its end and `via` as rings.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::PathReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::TraceReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// GLB: the loop as a line strip that ends where it begins. PNG: the same on the surface, with the
// points that were asked for.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::LoopReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// GLB: the faces whose corners all have a place, with these as texture coordinates: the square
// [0, 1]^2 is that about the circle of the reply's radius, its middle the point, u to the right and
// v down.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::LogmapReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// GLB: a node for each strip of the surface between two radii that follow each other, coloured by
// the distance halfway, with its area.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::MeasureReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// GLB: a node for each cell, coloured, with its number and area; or a line strip for each bisector;
// or the sites and the triangles between them. PNG: the cells, coloured alike, with the
// bisectors and the sites.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::VoronoiReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);
// GLB: a line strip for each isoline.
[[nodiscard]] Result<HttpResponse> draw(const Answered<proto::IsolinesReply>& answer,
                                        const proto::ReplyFormat& format, const Cancel& cancel);

}  // namespace geodesic::server
