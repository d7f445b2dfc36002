// Answers to HTTP in the negotiated format.
#pragma once

#include "proto/query_replies.h"
#include "proto/query_requests.h"
#include "server/field_queries.h"
#include "server/http_message.h"

namespace geodesic::server {

[[nodiscard]] HttpResponse json_reply(std::string json, int status = 200);

// As JSON, or the bare little-endian array: distances with shape (count), path
// points with shape (count, 3).
[[nodiscard]] HttpResponse encode(const Answered<proto::DistanceReply>& answer,
                                  const proto::ReplyFormat& format);
[[nodiscard]] HttpResponse encode(const Answered<proto::PathReply>& answer,
                                  const proto::ReplyFormat& format);
// Errors: not_acceptable (resolved points have no binary form).
[[nodiscard]] Result<HttpResponse> encode(const proto::NearestReply& reply,
                                          const proto::ReplyFormat& format);

}  // namespace geodesic::server
