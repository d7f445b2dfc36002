// Distance, path and nearest-point queries on the meshes of a catalogue: the
// middle one of a request's three steps. Fields that were computed whole are kept
// in a cache of their own, so that the second question about a source is cheap.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/field.h"
#include "core/wavefront.h"
#include "proto/query_replies.h"
#include "proto/query_requests.h"
#include "server/compute_pool.h"
#include "server/lru_cache.h"
#include "server/mesh_catalog.h"

namespace geodesic::server {

// An answer, and whether the field cache had what it is made of.
template <class Reply>
struct Answered {
  Reply reply;
  bool cache_hit = false;
};

// All methods may be called from any thread but a compute worker. Errors besides
// those named: what MeshCatalog::adjacency gives; index_out_of_range and
// snap_too_far for points, naming the parameter.
class FieldQueries {
 public:
  FieldQueries(MeshCatalog& catalog, ComputePool& pool, std::uint64_t field_cache_bytes);

  [[nodiscard]] Result<Answered<proto::DistanceReply>> distance(
      const std::string& mesh, const proto::DistanceRequest& request,
      const ClientGone& client_gone);
  [[nodiscard]] Result<Answered<proto::PathReply>> path(const std::string& mesh,
                                                        const proto::PathRequest& request,
                                                        const ClientGone& client_gone);
  [[nodiscard]] Result<proto::NearestReply> nearest(const std::string& mesh,
                                                    const proto::NearestRequest& request,
                                                    const ClientGone& client_gone);

  // Forgets the fields of a mesh.
  void forget(const std::string& mesh) { fields_.erase_prefix(mesh); }

  [[nodiscard]] CacheStats field_cache() const { return fields_.stats(); }

 private:
  [[nodiscard]] Result<Field> solve(const Adjacency& adjacency, proto::Method method,
                                    const std::vector<Source>& sources,
                                    const FieldLimits& limits, const ClientGone& client_gone);
  // A field of all vertices up to `max`, from the cache or computed.
  [[nodiscard]] Result<LruCache<Field>::Lookup> whole_field(
      const std::string& mesh, const Adjacency& adjacency, proto::Method method,
      const std::vector<Source>& sources, double max, const ClientGone& client_gone);

  MeshCatalog& catalog_;
  ComputePool& pool_;
  LruCache<Field> fields_;
  std::vector<WavefrontScratch> scratch_;  // one a compute slot
};

}  // namespace geodesic::server
