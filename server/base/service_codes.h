// What may go wrong in a service besides its input: no such thing, not allowed, no room, no time.
#pragma once

#include "core/base/error.h"

namespace geodesic {

// NOLINTBEGIN(readability-identifier-naming): called as clients are told.
struct ServiceCode {
  // No such path.
  static constexpr ErrorCode route_unknown{"route_unknown"};
  // No mesh of that id.
  static constexpr ErrorCode mesh_unknown{"mesh_unknown"};
  // The path exists, the HTTP method does not.
  static constexpr ErrorCode method_not_allowed{"method_not_allowed"};
  // No token, or one that is not valid (any more).
  static constexpr ErrorCode unauthorized{"unauthorized"};
  // The token lacks the scope that this needs.
  static constexpr ErrorCode forbidden{"forbidden"};
  // The body did not arrive in time.
  static constexpr ErrorCode request_timeout{"request_timeout"};
  // A body without a length.
  static constexpr ErrorCode length_required{"length_required"};
  // The closest point is farther than `max_snap`.
  static constexpr ErrorCode snap_too_far{"snap_too_far"};
  // The point is on a part of the surface that the query leaves out.
  static constexpr ErrorCode outside_region{"outside_region"};
  // The bytes are not those of the given digest.
  static constexpr ErrorCode digest_mismatch{"digest_mismatch"};
  // No job of that id (any more).
  static constexpr ErrorCode job_unknown{"job_unknown"};
  // The job has no result yet.
  static constexpr ErrorCode job_unfinished{"job_unfinished"};
  // The job was cancelled and has no result.
  static constexpr ErrorCode job_cancelled{"job_cancelled"};
  // The computation would take more memory than one may.
  static constexpr ErrorCode too_much_memory{"too_much_memory"};
  // The queue is full: try again later.
  static constexpr ErrorCode overloaded{"overloaded"};
  // This client asks for more than its share: try again later.
  static constexpr ErrorCode too_many_requests{"too_many_requests"};
  // The process is about to stop.
  static constexpr ErrorCode draining{"draining"};
  // The time allowed is over.
  static constexpr ErrorCode deadline{"deadline"};
  // The store cannot read or write.
  static constexpr ErrorCode store_failed{"store_failed"};
  // No room for an upload: the budget, the disk or a quota.
  static constexpr ErrorCode store_full{"store_full"};
  // The store does not answer: try again later.
  static constexpr ErrorCode store_unavailable{"store_unavailable"};
};
// NOLINTEND(readability-identifier-naming)

}  // namespace geodesic
