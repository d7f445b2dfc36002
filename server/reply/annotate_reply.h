// Answers to HTTP as the file that was uploaded, with the numbers as attributes of its vertices.
#pragma once

#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/gltf_file/annotation.h"
#include "proto/replies/replies.h"
#include "proto/wire/reply_format.h"
#include "proto/wire/requests.h"
#include "server/http/message.h"
#include "server/query/field_queries.h"

namespace geodesic::server {

// What a query's numbers are to be called in the file. Errors: value_out_of_range
// (`label_attribute`: both have one name).
[[nodiscard]] Result<std::vector<proto::VertexAttribute>> attributes_of(
    const proto::DistanceRequest& request, const proto::ReplyFormat& format);
[[nodiscard]] Result<std::vector<proto::VertexAttribute>> attributes_of(
    const proto::LogmapRequest& request, const proto::ReplyFormat& format);
[[nodiscard]] Result<std::vector<proto::VertexAttribute>> attributes_of(
    const proto::ExtentRequest& request, const proto::ReplyFormat& format);

// A float each: the distance, and if there are labels the place of its source in `from`; -1 where
// nothing is reached, for glTF has no infinity. The answer has its `upload`. Errors here and below:
// cancelled.
[[nodiscard]] Result<HttpResponse> annotate(Answered<proto::DistanceReply> answer,
                                            const proto::ReplyFormat& format, const Cancel& cancel);
// A float: the mean distance, or -1.
[[nodiscard]] Result<HttpResponse> annotate(Answered<proto::ExtentReply> answer,
                                            const proto::ReplyFormat& format, const Cancel& cancel);
// Three floats: the coordinates, and the distance; 0, 0, -1 where there is no place. Three more
// where directions are carried; 0, 0, 0 where there is none.
[[nodiscard]] Result<HttpResponse> annotate(Answered<proto::LogmapReply> answer,
                                            const proto::ReplyFormat& format, const Cancel& cancel);

}  // namespace geodesic::server
