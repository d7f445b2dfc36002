#include "proto/region/cut_regions.h"

#include <string>
#include <utility>
#include <vector>

#include "core/base/polled_fill.h"
#include "core/mesh/cut_mesh.h"
#include "proto/region/mark_faces.h"

namespace geodesic::proto {
namespace {

// By source face, not 0 for those that are left.
using Faces = std::vector<std::uint8_t>;

// All shapes but insides, whose faces are split first.
Result<void> mark_all(const std::vector<Shape>& region, const Mesh& mesh, const FileFaces& file,
                      Faces& faces, Poll& poll) {
  FaceMarker<std::uint8_t> marker(mesh, file, faces, poll);
  for (const Shape& shape : region) {
    if (std::holds_alternative<InsideShape>(shape.what)) continue;
    if (auto marked = marker.mark(shape, 1); !marked) return marked;
  }
  return {};
}

}  // namespace

Result<RegionFaces> faces_of_regions(const Mesh& whole, const Regions& regions,
                                     const FileFaces& file, const Cancel& cancel) {
  Poll poll(cancel);
  RegionFaces faces;
  polled_assign(faces.within, whole.source_face_count(), std::uint8_t{regions.within.empty()},
                poll);
  polled_assign(faces.forbid, whole.source_face_count(), std::uint8_t{0}, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (auto kept = mark_all(regions.within, whole, file, faces.within, poll); !kept) {
    return fail(std::move(kept.error()));
  }
  if (auto taken = mark_all(regions.forbid, whole, file, faces.forbid, poll); !taken) {
    return fail(std::move(taken.error()));
  }
  return faces;
}

Error nothing_left(const Regions& regions) {
  std::string parameter = "forbid";
  if (regions.forbid.empty()) parameter = regions.within.empty() ? "walls" : "within";
  return {ErrorCode::value_out_of_range, "no face of the mesh is left", parameter, {}, {}};
}

Result<std::vector<std::uint8_t>> faces_of_shape(const Mesh& whole, const Shape& shape,
                                                 const FileFaces& file, const Cancel& cancel) {
  Poll poll(cancel);
  Faces marked;
  polled_assign(marked, whole.source_face_count(), std::uint8_t{0}, poll);
  if (poll.stopped()) return fail_stopped(poll);
  FaceMarker<std::uint8_t> marker(whole, file, marked, poll);
  if (auto done = marker.mark(shape, 1); !done) return fail(std::move(done.error()));
  return marked;
}

Result<Mesh> cut_regions(const Mesh& whole, const Regions& regions, const FileFaces& file,
                         const Cancel& cancel) {
  auto faces = faces_of_regions(whole, regions, file, cancel);
  if (!faces) return fail(std::move(faces.error()));
  Faces& left = faces->within;
  Poll poll(cancel);
  for (std::size_t f = 0; f < left.size(); ++f) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (faces->forbid[f] != 0) left[f] = 0;
  }
  auto cut = cut_mesh(whole, left, cancel);
  if (cut || !(cut.error().code == ErrorCode::no_triangles)) return cut;
  return fail(nothing_left(regions));
}

}  // namespace geodesic::proto
