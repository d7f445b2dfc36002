// Exact geodesic distances by windows. Mitchell, Mount, Papadimitriou, "The
// discrete geodesic problem", 1987; Surazhsky, Surazhsky, Kirsanov, Gortler, Hoppe,
// "Fast exact and approximate geodesics on meshes", 2005.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

namespace exact {
struct PropagationMemory;
}

// By windows a vertex takes about so many times as long as by other fronts, so threads are of use
// on meshes as many times smaller.
inline constexpr std::size_t kTimesAsLongByWindows = 8;

// Memory that a query works in, kept for the next query on the same thread.
struct ExactScratch {
  ExactScratch();
  ~ExactScratch();
  ExactScratch(ExactScratch&&) noexcept;
  ExactScratch& operator=(ExactScratch&&) noexcept;

  // What the windows of the query take that is being answered; earlier ones have no part in it.
  [[nodiscard]] std::size_t window_bytes() const;

  std::unique_ptr<exact::PropagationMemory> memory;
};

// The lengths of the shortest paths over the surface from the nearest of the sources,
// exact but for rounding (about 1e-13 of a distance). All sources start together:
// where a window of one is nearer, the others' go no further. `parents` stays empty.
//
// The surface is any heap of triangles. Shortest paths cross an edge into every other
// face on it, and bend at a vertex where its angles let them: at saddle vertices, on
// the boundary, and where faces do not form one fan.
//
// With limits.keep_details, `windows` gets the windows into the faces: the distance of a
// point in a face is the least over the windows of its three sides, its corners
// (straight from there) and the sources in it. A window whose source is a vertex
// that a source was placed at has no pseudo-source.
//
// With limits.may_keep_refined, they may be `kept_windows` instead, over the refined surface.
//
// Without details windows run over the faces that have fewer edges in the way, perhaps not the
// mesh's own (exact/surface.h): the same distances, but for rounding.
//
// Each of n edges gets O(n) windows at worst, about 14 on scans.
//
// A Team in the Cancel may help (base/team.h): to the same bits on any number of threads.
// Errors: cancelled.
[[nodiscard]] Result<Field> exact_field(const Adjacency& adjacency, std::span<const Source> sources,
                                        const FieldLimits& limits, ExactScratch& scratch,
                                        const Cancel& cancel);

// Builds in the scratch what field_with_kept_windows needs of the surface, so that after this
// it asks the Cancel as often whatever the scratch was used for before: for who counts questions.
// Errors: cancelled.
[[nodiscard]] Result<void> make_ready_for_windows(const Adjacency& adjacency,
                                                  std::span<const Source> sources,
                                                  ExactScratch& scratch, const Cancel& cancel);

// The same, but a distance may be above that of the shortest path by at most the part
// `tolerance` of it, from 0, exact, to 1. Each is the length of a path on the surface. Where
// the surface is rough or round, this costs a fraction: narrow windows that went past
// a vertex on both sides are left behind (exact/propagation.h). Windows are
// kept of limits.detail_faces alone, or as by exact_field of the refined surface; the distance of a
// point there, as above, keeps the same promise. Where points are as far apart as rounding moves
// them, a distance may be below the straight line in space (field/straight_floor.h). Errors:
// cancelled.
[[nodiscard]] Result<Field> field_within(double tolerance, const Adjacency& adjacency,
                                         std::span<const Source> sources, const FieldLimits& limits,
                                         ExactScratch& scratch, const Cancel& cancel);

// The exact distances of all vertices, for `back_traced`. On machine parts it has `kept_windows`
// with `keep_details`, unless windows run over the Delaunay triangulation, on which points have no
// places. `counting` is asked until all distances are known, with details somewhat less often than
// without; `cancel`, after that. Errors: cancelled.
[[nodiscard]] Result<Field> field_with_kept_windows(const Adjacency& adjacency,
                                                    std::span<const Source> sources,
                                                    bool keep_details, ExactScratch& scratch,
                                                    const Cancel& counting, const Cancel& cancel);

// Whether exact_field keeps windows of the refined surface where it may. Takes some ten
// microseconds. False if the poll says to stop.
[[nodiscard]] bool prefers_refined(const Adjacency& adjacency, std::span<const Source> sources,
                                   Poll& poll);

// The field, but with the windows of the mesh's own faces and as far as the point: for what the
// windows of the refined surface do not tell, where rounding hides the place of a point or the way
// of a path. Takes as long as exact_field over needles. Errors: cancelled.
[[nodiscard]] Result<Field> exact_field_over_mesh(const Adjacency& adjacency, const Field& field,
                                                  const SurfacePoint& point, const Cancel& cancel);

}  // namespace geodesic
