#include "core/base/error.h"

namespace geodesic {

std::string_view name_of(ErrorCode code) {
  switch (code) {
#define GEODESIC_CODE(name) \
  case ErrorCode::name:     \
    return #name;
    GEODESIC_CODE(bad_syntax)
    GEODESIC_CODE(unknown_parameter)
    GEODESIC_CODE(route_unknown)
    GEODESIC_CODE(mesh_unknown)
    GEODESIC_CODE(method_not_allowed)
    GEODESIC_CODE(unauthorized)
    GEODESIC_CODE(forbidden)
    GEODESIC_CODE(not_acceptable)
    GEODESIC_CODE(request_timeout)
    GEODESIC_CODE(length_required)
    GEODESIC_CODE(too_large)
    GEODESIC_CODE(format_unknown)
    GEODESIC_CODE(mesh_invalid)
    GEODESIC_CODE(no_triangles)
    GEODESIC_CODE(too_many_vertices)
    GEODESIC_CODE(too_many_faces)
    GEODESIC_CODE(external_uri)
    GEODESIC_CODE(extension_required)
    GEODESIC_CODE(index_out_of_range)
    GEODESIC_CODE(value_out_of_range)
    GEODESIC_CODE(method_unknown)
    GEODESIC_CODE(snap_too_far)
    GEODESIC_CODE(no_hit)
    GEODESIC_CODE(unsupported)
    GEODESIC_CODE(digest_mismatch)
    GEODESIC_CODE(job_unknown)
    GEODESIC_CODE(job_unfinished)
    GEODESIC_CODE(job_cancelled)
    GEODESIC_CODE(too_much_memory)
    GEODESIC_CODE(overloaded)
    GEODESIC_CODE(too_many_requests)
    GEODESIC_CODE(draining)
    GEODESIC_CODE(cancelled)
    GEODESIC_CODE(deadline)
    GEODESIC_CODE(store_failed)
    GEODESIC_CODE(store_corrupt)
    GEODESIC_CODE(store_full)
    GEODESIC_CODE(store_unavailable)
    GEODESIC_CODE(internal)
#undef GEODESIC_CODE
  }
  return "internal";
}

}  // namespace geodesic
