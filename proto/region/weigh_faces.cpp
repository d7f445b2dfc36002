#include "proto/region/weigh_faces.h"

#include <cstdint>
#include <utility>

#include "core/base/polled_fill.h"
#include "proto/region/mark_faces.h"

namespace geodesic::proto {

Result<std::vector<double>> weigh_faces(const Mesh& mesh, const Mesh& whole, const Costs& costs,
                                        const FileFaces& file, const Cancel& cancel) {
  std::vector<double> of_source;
  std::vector<double> weights;
  if (!costs.have_weights()) return weights;
  const std::uint64_t faces = mesh.source_face_count();
  if (!costs.face_weights.empty() && costs.face_weights.size() != faces) {
    return fail_limit(ErrorCode::value_out_of_range,
                      "as many weights are wanted as the mesh has source faces", faces,
                      costs.face_weights.size(), "face_weights");
  }
  Poll poll(cancel);
  if (!poll.may_take(2 * sizeof(double) * faces)) return fail_stopped(poll);
  of_source = costs.face_weights;
  if (of_source.empty()) polled_assign(of_source, faces, 1.0, poll);
  if (poll.stopped()) return fail_stopped(poll);
  FaceMarker<double> marker(whole, file, of_source, poll);
  for (const WeightedRegion& region : costs.weights) {
    if (auto marked = marker.mark(region.shape, region.weight); !marked) {
      return fail(std::move(marked.error()));
    }
  }
  weights.reserve(mesh.face_count());
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    if (poll.cancelled()) return fail_stopped(poll);
    weights.push_back(of_source[mesh.source_of_face(f)]);
  }
  return weights;
}

}  // namespace geodesic::proto
