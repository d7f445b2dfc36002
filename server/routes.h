// The routes of the API: HTTP to request values, and answers to HTTP. The first
// and the last of a request's three steps; the one between is MeshCatalog's and
// FieldQueries'.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/compute_pool.h"
#include "server/config.h"
#include "server/field_queries.h"
#include "server/http_message.h"
#include "server/mesh_catalog.h"

namespace geodesic::server {

class Routes {
 public:
  Routes(const Config& config, MeshCatalog& catalog, FieldQueries& queries, ComputePool& pool);

  // Answers any request. May be called from any thread.
  [[nodiscard]] HttpResponse answer(HttpRequest& request);
  // Only /livez and /readyz: for a listener of its own.
  [[nodiscard]] HttpResponse answer_admin(HttpRequest& request);

  // From now on /readyz says no, so that balancers look elsewhere.
  void start_draining() { draining_ = true; }

  // The most bytes that a body of this request may have.
  [[nodiscard]] std::uint64_t max_body(std::string_view method, std::string_view path) const;

 private:
  struct Call;  // a request with its path taken apart

  [[nodiscard]] HttpResponse dispatch(Call& call);
  [[nodiscard]] HttpResponse one_mesh(Call& call);
  [[nodiscard]] HttpResponse probe(Call& call) const;
  [[nodiscard]] HttpResponse add_mesh(Call& call);
  [[nodiscard]] HttpResponse put_mesh(Call& call);
  [[nodiscard]] HttpResponse list_meshes(Call& call);
  [[nodiscard]] HttpResponse mesh_metadata(Call& call);
  [[nodiscard]] HttpResponse mesh_source(Call& call);
  [[nodiscard]] HttpResponse prepare_mesh(Call& call);
  [[nodiscard]] HttpResponse delete_mesh(Call& call);
  [[nodiscard]] HttpResponse query(Call& call, std::string_view action);
  // Any query: parameters to a Request, its answer to the format asked for.
  template <class Request>
  [[nodiscard]] HttpResponse answer_query(const Call& call);
  [[nodiscard]] HttpResponse status() const;

  const Config config_;
  MeshCatalog& catalog_;
  FieldQueries& queries_;
  ComputePool& pool_;
  std::atomic<bool> draining_{false};
};

}  // namespace geodesic::server
