// Answers to HTTP in the negotiated format, where that is numbers: JSON, bare arrays,
// NumPy's files and frames. What has to be drawn is draw_reply.h's.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/replies/replies.h"
#include "proto/wire/reply_format.h"
#include "server/http/message.h"
#include "server/query/field_queries.h"

namespace geodesic::server {

[[nodiscard]] HttpResponse json_reply(std::string json, int status = 200);

// A number as a header has it: as many digits as read back to the same value.
[[nodiscard]] std::string header_number(double value);
// Geo-Cache, where there is something to say.
void add_cache_header(HttpResponse& response, std::optional<bool> hit);

// What `of=means` found, as a field of distances, for all formats that those have.
[[nodiscard]] Answered<proto::DistanceReply> means_as_distances(
    const Answered<proto::ExtentReply>& answer);

// How many numbers a reply has, more or less; and the bytes of memory that it takes until it is
// encoded, and packed if it can be.
struct ReplySize {
  std::uint64_t numbers = 0;
  std::uint64_t bytes = 0;
};
[[nodiscard]] ReplySize size_of(const Answered<proto::DistanceReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::PathReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::TraceReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::TableReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::IsolinesReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::SamplesReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::MeasureReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::ExtentReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::VoronoiReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::LoopReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::LogmapReply>& answer,
                                const proto::ReplyFormat& format);
[[nodiscard]] ReplySize size_of(const Answered<proto::NearestReply>& answer,
                                const proto::ReplyFormat& format);

// As JSON; as a little-endian array, bare or with NumPy's header (distances with
// shape (count), path points with shape (count, 3), a table with shape (rows,
// columns); whole numbers are quantised over [0, Geo-Max]); or as a frame of all the
// arrays of the reply, float64 and uint32 (4294967295: none), whose JSON has the rest.
// The format is one that the query offers, and no drawing. Errors here and below: cancelled.
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::DistanceReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::PathReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::TraceReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::TableReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::LoopReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::LogmapReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);

// These have no array, and are always JSON.
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::IsolinesReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::SamplesReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::MeasureReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::ExtentReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::VoronoiReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);
[[nodiscard]] Result<HttpResponse> encode(Answered<proto::NearestReply> answer,
                                          const proto::ReplyFormat& format, const Cancel& cancel);

}  // namespace geodesic::server
