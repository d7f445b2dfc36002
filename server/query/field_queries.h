// The queries on the meshes of a catalogue: the middle one of a request's three
// steps. Each resolves its points, computes in compute slots and says what it found
// in the client's numbers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/refine/line_sides.h"
#include "core/surface/point.h"
#include "proto/replies/replies.h"
#include "proto/wire/requests.h"
#include "server/base/lru_cache.h"
#include "server/compute/pool.h"
#include "server/compute/rows_ahead.h"
#include "server/places/resolve_point.h"
#include "server/query/fields.h"
#include "server/query/mesh_catalog.h"
#include "server/query/uploaded_gltf.h"

namespace geodesic::server {

// An answer, whether the field cache had what it is made of (nothing where no field
// is kept), and the surface it is about.
template <class Reply>
struct Answered {
  Reply reply;
  std::optional<bool> cache_hit;
  std::shared_ptr<const Adjacency> adjacency;
  // To be called, if set, before the reply is complete: with the memory for it, where long work
  // may be done. `numbers` are those that come then.
  std::function<Result<void>(Reply&, const Cancel&)> complete;
  std::uint64_t numbers = 0;
  // The same for what only a drawing has: to be called, if set, before the reply is drawn.
  std::function<Result<void>(Reply&, const Cancel&)> complete_drawing;
  std::uint64_t drawn_numbers = 0;
  // Where lines have split faces, the field: a drawing has the vertices of the surface itself then,
  // for those of the file are not all of them.
  std::shared_ptr<const Field> drawn_field;
  // Of signed distances, by vertex of that surface: 1 where they are below 0.
  std::shared_ptr<const std::vector<std::uint8_t>> drawn_inside;
  // The file that the numbers are to be written into, where they are.
  std::shared_ptr<const UploadedGltf> upload;
  // Of a table whose rows go another way: begins them, each as the bytes that `encode` makes of it
  // in a slot, in blocks of so many.
  using EncodeRow =
      std::function<Result<std::string>(std::size_t row, std::span<const double>, const Cancel&)>;
  std::function<Result<std::unique_ptr<RowsAhead>>(EncodeRow encode, std::size_t block)> rows;
  // To be called, if set, before these: with the memory for so many bytes, where long work is done.
  std::function<Result<void>(Reply&)> before_rows;
  std::uint64_t bytes_of_estimates = 0;
};

// All methods may be called from any thread but a compute worker. Errors besides
// those named: what MeshCatalog::adjacency gives; index_out_of_range,
// value_out_of_range, outside_region, snap_too_far and mesh_invalid for points, naming the
// parameter.
class FieldQueries {
 public:
  FieldQueries(MeshCatalog& catalog, ComputePool& pool, std::uint64_t field_cache_bytes,
               Metrics& metrics);

  [[nodiscard]] Result<Answered<proto::DistanceReply>> answer(const AskedSurface& surface,
                                                              const proto::DistanceRequest& request,
                                                              const Caller& caller);
  [[nodiscard]] Result<Answered<proto::PathReply>> answer(const AskedSurface& surface,
                                                          const proto::PathRequest& request,
                                                          const Caller& caller);
  [[nodiscard]] Result<Answered<proto::TableReply>> answer(const AskedSurface& surface,
                                                           const proto::TableRequest& request,
                                                           const Caller& caller);
  // Errors: too_large (levels by `step`, segments).
  [[nodiscard]] Result<Answered<proto::IsolinesReply>> answer(const AskedSurface& surface,
                                                              const proto::IsolinesRequest& request,
                                                              const Caller& caller);
  [[nodiscard]] Result<Answered<proto::SamplesReply>> answer(const AskedSurface& surface,
                                                             const proto::SamplesRequest& request,
                                                             const Caller& caller);
  // Errors of its drawing: too_large (crossings of faces by the radii).
  [[nodiscard]] Result<Answered<proto::MeasureReply>> answer(const AskedSurface& surface,
                                                             const proto::MeasureRequest& request,
                                                             const Caller& caller);
  [[nodiscard]] Result<Answered<proto::ExtentReply>> answer(const AskedSurface& surface,
                                                            const proto::ExtentRequest& request,
                                                            const Caller& caller);
  // Errors: too_large (segments of bisectors).
  [[nodiscard]] Result<Answered<proto::VoronoiReply>> answer(const AskedSurface& surface,
                                                             const proto::VoronoiRequest& request,
                                                             const Caller& caller);
  // Errors: value_out_of_range (direction, angle), too_large (length).
  [[nodiscard]] Result<Answered<proto::TraceReply>> answer(const AskedSurface& surface,
                                                           const proto::TraceRequest& request,
                                                           const Caller& caller);
  // Errors: no_loop, value_out_of_range (normal).
  [[nodiscard]] Result<Answered<proto::LoopReply>> answer(const AskedSurface& surface,
                                                          const proto::LoopRequest& request,
                                                          const Caller& caller);
  // Errors: value_out_of_range (from: where directions have no angle).
  [[nodiscard]] Result<Answered<proto::LogmapReply>> answer(const AskedSurface& surface,
                                                            const proto::LogmapRequest& request,
                                                            const Caller& caller);
  [[nodiscard]] Result<Answered<proto::NearestReply>> answer(const AskedSurface& surface,
                                                             const proto::NearestRequest& request,
                                                             const Caller& caller);

  // Runs `job(const Cancel&)`, which returns a Result, in a compute slot.
  template <class Job>
  [[nodiscard]] auto in_slot(Job&& job, const Caller& caller) {
    return fields_.compute_once([&](SolveScratch&, const Cancel& cancel) { return job(cancel); },
                                caller);
  }

  // Forgets the fields of a mesh.
  void forget(const std::string& mesh) { fields_.forget(mesh); }

  void set_cache_budget(std::uint64_t bytes) { fields_.set_cache_budget(bytes); }
  [[nodiscard]] CacheStats field_cache() const { return fields_.cache(); }
  [[nodiscard]] std::vector<CacheEntry> cached_fields(std::size_t most) const {
    return fields_.cached(most);
  }

 private:
  // The surface of a request, and its points there.
  class Place;
  [[nodiscard]] Result<Place> find(const AskedSurface& surface, const Caller& caller);
  // The same for a query by a method, with the surface's costs. Errors: too_large
  // (points_per_edge), and those of proto::weigh_faces.
  [[nodiscard]] Result<Place> find(const AskedSurface& surface, const proto::MethodChoice& method,
                                   const Caller& caller);

  // How the rows of a large table are begun, which have no sources in `question` yet. `to`: the
  // columns that are points. `lines`: the others, if there are any. `landmarks`: by how many of the
  // columns, which are all points then, others are estimated; 0: none is.
  [[nodiscard]] Result<void> begin_rows(FieldQuestion question, FieldRows from,
                                        std::vector<SurfacePoint> to,
                                        std::shared_ptr<const LineColumns> lines,
                                        std::uint64_t landmarks, const Caller& caller,
                                        Answered<proto::TableReply>& answer);

  // What ways over the surface cost, which are not their lengths.
  [[nodiscard]] Result<std::shared_ptr<const TravelCost>> cost_of(const AskedSurface& surface,
                                                                  const Mesh& mesh,
                                                                  const Caller& caller);

  // What is inside a closed line. Errors, naming `signed`: those of LineSides::find.
  [[nodiscard]] Result<std::shared_ptr<const LineSides>> sides_of(const Adjacency& adjacency,
                                                                  const SurfacePolyline& line,
                                                                  const Caller& caller);

  MeshCatalog& catalog_;
  ComputePool& pool_;
  Fields fields_;
};

}  // namespace geodesic::server
