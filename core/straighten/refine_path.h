// From a path traced through a field to a locally shortest one (shorten_path.h), on the
// right side of what is in the way.
//
// Where two ways to a target are about as long as each other, approximate distances may
// send a trace round a bump by the longer one. What is traced then is longer, once it is
// pulled straight, than the field says that the target is away, and by more than the field
// errs. In that case the target's neighbours are asked for their ways, too.
#pragma once

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// `traced` is trace_path's for that field and target. The result is never longer than what
// shorten_path makes of it. One path in twenty by `back_traced` takes a second look, and
// then some milliseconds; those by other methods take none.
// Errors: cancelled.
[[nodiscard]] Result<Path> refine_path(const Adjacency& adjacency, const Field& field,
                                       const SurfacePoint& target, const Path& traced,
                                       const Cancel& cancel);

}  // namespace geodesic
