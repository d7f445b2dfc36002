// What all replies have in common, added once they are made: how long caches may keep
// them and by which tag, gzip for text, where the time went, and the trace they are
// part of.
#pragma once

#include <string>
#include <string_view>

#include "core/base/cancel.h"
#include "server/base/stage_times.h"
#include "server/http/message.h"

namespace geodesic::server {

// Whether the client takes gzip.
[[nodiscard]] bool admits_gzip(const HttpRequest& request);

// Packs text of more than 1 kB for those who take it, unless it is packed; what is
// binary stays bare. No reply any more if the poll, where there is one, says to stop.
void pack(const HttpRequest& request, HttpResponse& response, Poll* poll);

// Packs what is to be packed. A reply to GET or HEAD that has no tag of its own gets one of its
// bytes, and is a 304 for those who have them. A 304 has the tag, packed or bare, that the client
// named, and `Vary: Accept-Encoding` unless it has the type of a reply that is never packed. One
// that does not say how long it holds must be asked for again each time (`no-cache`). Errors are
// not kept at all.
void finish_reply(const HttpRequest& request, HttpResponse& response);

// Server-Timing: the stages that took time, in milliseconds.
void add_timing(const StageTimes& times, HttpResponse& response);

// The request's `traceparent` (W3C Trace Context), or nothing if it is malformed.
[[nodiscard]] std::string_view trace_of(const HttpRequest& request);

}  // namespace geodesic::server
