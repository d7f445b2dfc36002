// From a path traced through a field to a locally shortest one (shorten_path.h), on the
// right side of what is in the way.
//
// Where two ways to a target are about as long as each other, approximate distances may
// send a trace round a bump by the longer one. What is traced then is longer, once it is
// pulled straight, than the field says that the target is away, and by more than the field
// errs. In that case the target's neighbours are asked for their ways, too.
#pragma once

#include <cstdint>
#include <optional>

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

// How much is done to a path that was traced through a field.
enum class PathWork : std::uint8_t { refined, traced };

// The path from the field's nearest source to `target`, by `trace_path` and, where that is asked
// for, `refine_path`; nothing where there is none. Distances by `back_traced` do not say where
// between its vertices a way crosses an edge, so a path through them that is only traced is pulled
// straight within its faces. Errors: cancelled.
[[nodiscard]] Result<std::optional<Path>> path_through(const Adjacency& adjacency,
                                                       const Field& field,
                                                       const SurfacePoint& target, PathWork work,
                                                       const Cancel& cancel);

}  // namespace geodesic
