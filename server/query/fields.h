// The distance fields that queries are answered from: computed in compute slots,
// and kept when whole, so that the second question about a source is cheap.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/field/travel_cost.h"
#include "core/solve/pair_search.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"
#include "proto/wire/methods.h"
#include "server/base/caller.h"
#include "server/base/lru_cache.h"
#include "server/compute/pool.h"
#include "server/metrics/metrics.h"
#include "server/places/field_rows.h"
#include "server/places/field_sources.h"
#include "server/places/line_columns.h"
#include "server/query/asked_sources.h"
#include "server/query/mesh_catalog.h"
#include "server/query/scratch_use.h"

namespace geodesic::server {

// What a whole field depends on.
struct FieldQuestion {
  std::string surface;  // its key for fields (mesh_catalog.h)
  std::shared_ptr<const Adjacency> adjacency;
  proto::MethodChoice method;
  FieldSources from;
  double max = std::numeric_limits<double>::infinity();  // mesh units, or what costs are in
  std::shared_ptr<const TravelCost> cost = nullptr;      // of `steiner`; null: lengths
};

// Whether a field is to serve points inside faces and paths, too. By an exact method these need
// much more memory than vertices do, so a field is kept with or without.
enum class Details { none, kept };

// The distances of some points.
struct PointDistances {
  std::vector<double> distances;      // kUnreached where there is none
  std::vector<std::uint32_t> labels;  // if asked for, the source of each; kNone where unreached
  bool hit = false;                   // the field was there

  [[nodiscard]] std::size_t bytes() const {
    return distances.capacity() * sizeof(double) + labels.capacity() * sizeof(std::uint32_t);
  }
};

// All methods may be called from any thread but a compute worker. Errors: those
// of ComputePool::run.
class Fields {
 public:
  Fields(ComputePool& pool, std::uint64_t cache_bytes, Metrics& metrics);
  ~Fields();
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  // The field of all vertices up to the question's `max`, from the cache or
  // computed.
  [[nodiscard]] Result<LruCache<Field>::Lookup> whole(const FieldQuestion& question,
                                                      Details details, const Caller& caller);

  // Whether the field is not there, and it is better to search for one target than to
  // compute and keep it: for the first question about a source on a large mesh. The
  // second one is told to take the whole field, unless its details would take too much memory.
  [[nodiscard]] bool is_to_be_searched(const FieldQuestion& question, Details details);

  // The way from the question's only source to one point, and if wanted the path that a
  // whole field would give. In the slot that `scratch` is of; keeps nothing.
  [[nodiscard]] Result<Pair> search(const FieldQuestion& question, const SurfacePoint& to,
                                    PairPath path, SolveScratch& scratch, const Cancel& cancel,
                                    const Caller& caller);

  // From a whole field that is there. Or else, for a single point, as is_to_be_searched
  // says; for several from a field that stops at the points and is not kept.
  [[nodiscard]] Result<PointDistances> at_points(const FieldQuestion& question,
                                                 std::span<const SurfacePoint> points, bool labels,
                                                 const Caller& caller);

  // The same from each of `from` apart, in as many compute slots as are free: a row
  // each, one after the other. `question` has no sources; there are no labels.
  [[nodiscard]] Result<PointDistances> table(const FieldQuestion& question, const FieldRows& from,
                                             std::span<const SurfacePoint> to,
                                             const Caller& caller);

  // The entries of the columns of a table that are lines, each line's field in a slot of its own.
  // `question` has no sources. Whether all fields were there.
  [[nodiscard]] Result<bool> fill(const FieldQuestion& question, LineColumns& lines,
                                  const Caller& caller);

  // The distances of the points as the whole field of a row has them, and so the same whatever else
  // is asked: a row of a table, as a part of ComputePool::run_each. The field is not kept, and does
  // not end at the points. `question` has no sources. `faces`: of
  // which details are kept, among them those around the points; if there are none, no details.
  [[nodiscard]] Result<std::vector<double>> row(const FieldQuestion& question,
                                                const FieldRows& from, std::size_t number,
                                                std::span<const SurfacePoint> points,
                                                std::span<const std::uint32_t> faces,
                                                Worker& worker, const GiveWay& give_way,
                                                const Caller& caller);

  // Runs `job(SolveScratch&, const Cancel&)`, which returns a Result, in a compute
  // slot. It is cancelled when the client is gone, and its progress is the caller's. Where
  // others hold the memory that it needs, it is run again from the start once there is room.
  template <class Job>
  [[nodiscard]] auto compute(Job&& job, const Caller& caller) {
    return pool_.run_with_room([&](Worker& worker) { return run(job, worker, caller); }, caller);
  }
  // The same for a job that cannot be run twice.
  template <class Job>
  [[nodiscard]] auto compute_once(Job&& job, const Caller& caller) {
    return pool_.run([&](Worker& worker) { return run(job, worker, caller); }, caller);
  }

  // Forgets the fields of a mesh.
  void forget(const std::string& mesh) { cache_.erase_prefix(mesh + "/"); }

  void set_cache_budget(std::uint64_t bytes) { cache_.set_budget(bytes); }
  [[nodiscard]] CacheStats cache() const { return cache_.stats(); }
  [[nodiscard]] std::vector<CacheEntry> cached(std::size_t most) const {
    return cache_.entries(most);
  }

 private:
  static constexpr std::size_t kSourcesRemembered = 4096;
  // Scratch memory of all slots may be this part of what all computations may have.
  static constexpr std::uint64_t kIdlePart = 4;

  template <class Job>
  [[nodiscard]] auto run(Job& job, Worker& worker, const Caller& caller) {
    return run_part(
        job, worker, [] { return false; }, caller);
  }
  // As a part of ComputePool::run_each.
  template <class Job, class MustGiveWay>
  [[nodiscard]] auto run_part(Job&& job, Worker& worker, const MustGiveWay& give_way,
                              const Caller& caller) {
    worker.memory->limit_to_query();
    ScratchUse scratch = scratch_of(worker);
    const Cancel cancel([&] { return give_way() || caller(); }, caller.progress,
                        &worker.memory->budget());
    auto result = job(scratch.get(), cancel);
    scratch.done(bytes_of(result));
    return result;
  }
  [[nodiscard]] ScratchUse scratch_of(const Worker& worker) {
    const std::uint64_t all = pool_.memory().limits.all;
    return {scratch_[worker.slot], *worker.memory, all / kIdlePart / scratch_.size()};
  }
  // What a job hands on, where that is large.
  template <class Handed>
  [[nodiscard]] static std::uint64_t bytes_of(const Result<Handed>& result) {
    if constexpr (requires { result->bytes(); }) return result ? result->bytes() : 0;
    return 0;
  }
  [[nodiscard]] static std::uint64_t bytes_of(const Result<std::vector<double>>& distances) {
    return distances ? distances->capacity() * sizeof(double) : 0;
  }

  // The same without the case of one point, in the slot that `scratch` is of. `targets`
  // decide the distances of the points.
  [[nodiscard]] Result<PointDistances> read_points(const FieldQuestion& question,
                                                   std::span<const SurfacePoint> points,
                                                   std::span<const std::uint32_t> targets,
                                                   bool labels, SolveScratch& scratch,
                                                   const Cancel& cancel, const Caller& caller);
  [[nodiscard]] Result<PointDistances> search_points(const FieldQuestion& question,
                                                     std::span<const SurfacePoint> points,
                                                     SolveScratch& scratch, const Cancel& cancel,
                                                     const Caller& caller);
  // `row`, in the slot that `scratch` is of.
  [[nodiscard]] Result<std::vector<double>> read_row(const FieldQuestion& question,
                                                     const FieldRows& from, std::size_t number,
                                                     std::span<const SurfacePoint> points,
                                                     std::span<const std::uint32_t> faces,
                                                     SolveScratch& scratch, const Cancel& cancel,
                                                     const Caller& caller);
  // What the field of one line tells, in the slot that `scratch` is of. Whether it was there.
  [[nodiscard]] Result<bool> fill_from(const FieldQuestion& question, std::size_t number,
                                       LineColumns& lines, SolveScratch& scratch,
                                       const Cancel& cancel, const Caller& caller);
  [[nodiscard]] Result<Field> solve(const FieldQuestion& question, const FieldLimits& limits,
                                    SolveScratch& scratch, const Cancel& cancel,
                                    const Caller& caller);

  ComputePool& pool_;
  Metrics& metrics_;
  LruCache<Field> cache_;
  std::vector<KeptScratch> scratch_;  // one a compute slot
  AskedSources asked_{kSourcesRemembered};
};

}  // namespace geodesic::server
