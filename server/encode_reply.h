// Answers to HTTP in the negotiated format.
#pragma once

#include "proto/query_replies.h"
#include "proto/reply_format.h"
#include "server/field_queries.h"
#include "server/http_message.h"

namespace geodesic::server {

[[nodiscard]] HttpResponse json_reply(std::string json, int status = 200);

// As JSON, or the bare little-endian array: distances with shape (count), path
// points with shape (count, 3), a table with shape (rows, columns). The format is
// one that the query offers.
[[nodiscard]] HttpResponse encode(const Answered<proto::DistanceReply>& answer,
                                  const proto::ReplyFormat& format);
[[nodiscard]] HttpResponse encode(const Answered<proto::PathReply>& answer,
                                  const proto::ReplyFormat& format);
[[nodiscard]] HttpResponse encode(const Answered<proto::TraceReply>& answer,
                                  const proto::ReplyFormat& format);
[[nodiscard]] HttpResponse encode(const Answered<proto::TableReply>& answer,
                                  const proto::ReplyFormat& format);

// These have no array, and are always JSON.
[[nodiscard]] HttpResponse encode(const Answered<proto::IsolinesReply>& answer,
                                  const proto::ReplyFormat& format);
[[nodiscard]] HttpResponse encode(const Answered<proto::SamplesReply>& answer,
                                  const proto::ReplyFormat& format);
[[nodiscard]] HttpResponse encode(const Answered<proto::NearestReply>& answer,
                                  const proto::ReplyFormat& format);

}  // namespace geodesic::server
