#include "server/query/mesh_catalog.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include "core/base/team.h"
#include "core/curves/source_lines.h"
#include "core/mesh/weld.h"
#include "proto/formats/decode_mesh.h"
#include "proto/mesh/metadata.h"
#include "proto/region/cut_regions.h"
#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/compute/memory.h"
#include "server/decoder/mesh_form.h"
#include "server/places/walled_surface.h"
#include "server/store/mesh_id.h"

namespace geodesic::server {
namespace {

std::span<const std::byte> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

// The keys of a surface in the cache of prepared things, by kind. They begin with the mesh's id.
std::string adjacency_key(const std::string& surface) { return surface + "/adjacency"; }
std::string closest_points_key(const std::string& surface) { return surface + "/closest_points"; }

// An adjacency holds on to its mesh, which the mesh cache may have dropped.
std::size_t bytes_of(const PreparedSurface& surface) {
  return surface.adjacency->bytes() + surface.adjacency->mesh().bytes() +
         (surface.refinement != nullptr ? surface.refinement->bytes() : 0);
}
std::size_t bytes_of(const std::shared_ptr<const ClosestPointIndex>& index) {
  return index->bytes();
}
std::size_t bytes_of(const std::shared_ptr<const proto::FaceMaterials>& materials) {
  return materials->bytes();
}
std::size_t bytes_of(const std::shared_ptr<const proto::ToldParts>& parts) {
  return parts->bytes();
}
std::size_t bytes_of(const std::shared_ptr<const proto::FaceNumbers>& numbers) {
  return numbers->by_face.capacity() * sizeof(double);
}

// Embree takes one of the process's 1,024 keys of threads for each index. Without any left, nobody
// gets random numbers either.
constexpr std::size_t kMostIndexes = 400;

// Stored files that are read while every slot is decoding one.
constexpr std::size_t kFilesAhead = 4;

// About which part of an upload's time it takes to build the mesh, and of that to decode.
constexpr double kBuilding = 0.5;
constexpr double kDecoding = 0.4;

Cancel cancel_of(const Caller& caller) {
  return Cancel(std::cref(caller), caller.progress, JobMemory::budget_here());
}

Result<std::shared_ptr<const Adjacency>> prepare(std::shared_ptr<const Mesh> mesh,
                                                 ComputePool& pool, const Caller& caller) {
  ComputePool::Help help(pool, mesh->vertex_count() >= Team::kFewestVertices);
  auto adjacency = Adjacency::build(std::move(mesh), cancel_of(caller).helped_by(help.team()));
  if (!adjacency) return fail(std::move(adjacency.error()));
  return std::make_shared<const Adjacency>(std::move(*adjacency));
}

}  // namespace

AskedSurface::AskedSurface(std::string mesh, proto::Regions regions, proto::Costs costs)
    : mesh_(std::move(mesh)), regions_(std::move(regions)), costs_(std::move(costs)), key_(mesh_) {
  if (!is_whole()) key_ += "/part-" + sha256_hex(proto::canonical_text(regions_));
  field_key_ = key_;
  if (!costs_.are_lengths()) field_key_ += "/cost-" + sha256_hex(proto::canonical_text(costs_));
}

MeshCatalog::MeshCatalog(MeshStore& store, ComputePool& pool, const CatalogLimits& limits,
                         Metrics& metrics, DecoderProcesses* decoders)
    : store_(store),
      pool_(pool),
      file_turns_(pool.slots() + kFilesAhead, std::chrono::seconds(10),
                  "too many stored files are being read; try again"),
      metrics_(metrics),
      decoders_(decoders),
      decode_limits_(limits.decode),
      least_index_bytes_(limits.adjacency_cache_bytes / kMostIndexes),
      meshes_(limits.mesh_cache_bytes, [](const Mesh& mesh) { return mesh.bytes(); }),
      prepared_(limits.adjacency_cache_bytes,
                [this](const Prepared& prepared) {
                  const std::size_t bytes =
                      std::visit([](const auto& value) { return bytes_of(value); }, prepared);
                  return std::holds_alternative<std::shared_ptr<const ClosestPointIndex>>(prepared)
                             ? std::max(bytes, least_index_bytes_.load())
                             : bytes;
                }),
      uploads_(0, [](const Upload&) { return std::size_t{1}; }) {}

void MeshCatalog::set_limits(const CatalogLimits& limits) {
  decode_limits_.set(limits.decode);
  if (decoders_ != nullptr) decoders_->set_limits(limits.decoder);
  meshes_.set_budget(limits.mesh_cache_bytes);
  least_index_bytes_ = limits.adjacency_cache_bytes / kMostIndexes;
  prepared_.set_budget(limits.adjacency_cache_bytes);
}

Result<MeshCatalog::Upload> MeshCatalog::add(std::string bytes, const proto::ImportOptions& options,
                                             const Caller& caller, const std::string& name) {
  const auto digest = sha256_hex(bytes, std::cref(caller));
  if (!digest) return fail(caller.why_stopped());
  const std::string id = mesh_id(*digest, proto::canonical_text(options));
  const auto stored = store_.is_stored(id);
  if (!stored) return fail(stored.error());
  if (*stored) {
    auto description = metadata(id, caller);
    Result<void> sure = description ? make_sure(id, bytes) : fail(description.error());
    if (sure && !name.empty() && !proto::name_in(*description)) {
      if (auto named = set_name(id, name, true, caller)) {
        description = std::move(named);
      } else if (named.error().code == ServiceCode::mesh_unknown) {
        sure = fail(std::move(named.error()));
      }
    }
    if (sure) return Upload{id, std::move(*description), false};
    // Removed since, or found damaged: then this upload puts it back.
    const ErrorCode code = sure.error().code;
    if (code != ServiceCode::mesh_unknown && code != InputCode::store_corrupt) {
      return fail(std::move(sure.error()));
    }
  }

  const auto upload = uploads_.get_or_create(
      id,
      [&]() -> Result<std::shared_ptr<const Upload>> {
        auto described =
            pool_.run([&](Worker&) { return describe(id, bytes, options, caller); }, caller);
        if (!described) return fail(std::move(described.error()));
        if (!name.empty()) {
          auto named = proto::with_name(described->description, name);
          if (!named) return fail(std::move(named.error()));
          described->description = std::move(*named);
        }
        auto complete = proto::with_state(described->description, true, true);
        if (!complete) return fail(std::move(complete.error()));
        if (caller()) return fail(caller.why_stopped());  // from here on it is stored whole
        // Not in a compute slot: a slow store must not keep queries from theirs.
        if (auto put = store_.put(id, bytes, described->description); !put) {
          return fail(std::move(put.error()));
        }
        // The caches save the first query the work. A load that began before the mesh
        // was stored may hand its own failure on: then that query does it after all.
        (void)meshes_.get_or_create(
            id, [&]() -> Result<std::shared_ptr<const Mesh>> { return described->mesh; });
        (void)prepared_.get_or_create(
            adjacency_key(id), [&]() -> Result<std::shared_ptr<const Prepared>> {
              return std::make_shared<const Prepared>(PreparedSurface{described->adjacency, {}});
            });
        keep_prepared(id, described->adjacency);
        keep_materials(id, std::move(described->materials), caller);
        return std::make_shared<const Upload>(Upload{id, std::move(*complete), true});
      },
      caller);
  if (!upload) return fail(upload.error());
  Upload added = *upload->value;
  // It may be another's upload of the same bytes, which had no name.
  if (!name.empty() && !proto::name_in(added.metadata)) {
    if (auto named = set_name(id, name, true, caller)) added.metadata = std::move(*named);
  }
  return added;
}

Result<void> MeshCatalog::make_sure(const std::string& id, std::string_view bytes) {
  if (store_.is_surely_whole(id)) return {};
  const std::lock_guard lock(descriptions_mutex_);
  const auto description = description_of(id, /*afresh=*/true);
  if (!description) return fail(description.error());
  if (!*description) return unknown_mesh();
  return store_.put(id, bytes, **description);
}

Result<proto::DecodedMesh> MeshCatalog::decode(const std::string& bytes,
                                               const proto::ImportOptions& options,
                                               const Caller& caller) {
  const auto limits = decode_limits_.get();
  return decoders_ != nullptr ? decoders_->decode(bytes, *limits, options, caller)
                              : proto::decode_mesh(as_bytes(bytes), *limits, options);
}

Result<MeshCatalog::Built> MeshCatalog::build(const std::string& bytes,
                                              const proto::ImportOptions& options,
                                              const Caller& caller) {
  auto decoded = decode(bytes, options, caller);
  if (!decoded) return fail(std::move(decoded.error()));
  const Caller rest = caller.part(kDecoding, 1);
  if (options.weld_tolerance > 0) {
    const auto moved = weld_within(decoded->soup, options.weld_tolerance, cancel_of(caller));
    if (!moved) return fail(moved.error());
    if (*moved > 0) {
      decoded->findings.push_back(
          {"vertices_moved",
           *moved,
           {},
           std::to_string(*moved) + " vertices were moved onto others within the tolerance."});
    }
  }
  ComputePool::Help help(pool_, decoded->soup.positions.size() >= Team::kFewestVertices);
  auto mesh = Mesh::build(decoded->soup, options.weld, cancel_of(rest).helped_by(help.team()));
  if (!mesh) return fail(std::move(mesh.error()));
  decoded->soup = {};  // the mesh has it all
  return Built{std::move(*decoded), std::make_shared<const Mesh>(std::move(*mesh))};
}

Result<FormFile> MeshCatalog::file_of_form(std::string_view body, std::string_view boundary,
                                           const Caller& caller) {
  return pool_.run(
      [&](Worker&) {
        const auto limits = decode_limits_.get();
        return decoders_ != nullptr ? decoders_->file_of_form(body, boundary, *limits, caller)
                                    : server::file_of_form(body, boundary, *limits);
      },
      caller);
}

// Runs on a compute worker. The description tells of the topology, so the adjacency
// is made, and kept by who can use it.
Result<MeshCatalog::Described> MeshCatalog::describe(const std::string& id,
                                                     const std::string& bytes,
                                                     const proto::ImportOptions& options,
                                                     const Caller& caller) {
  auto built = step("decode", Stage::load, caller,
                    [&] { return build(bytes, options, caller.part(0, kBuilding)); });
  if (!built) return fail(std::move(built.error()));
  const auto prepared = step("prepare", Stage::prepare, caller, [&] {
    return prepare(built->mesh, pool_, caller.part(kBuilding, 1));
  });
  if (!prepared) return fail(prepared.error());
  auto adjacency = *prepared;
  const Cancel cancel = cancel_of(caller);
  Poll poll(cancel);
  std::vector<proto::ToldBoundary> boundaries;
  for (const BoundarySize& loop : longest_boundaries(*adjacency, proto::kMostBoundaries, poll)) {
    boundaries.push_back({loop.length, loop.edges, loop.vertex, loop.is_closed});
  }
  if (poll.stopped()) return fail_stopped(poll);
  std::string description =
      proto::describe_mesh(id, bytes.size(), options, built->decoded, *adjacency, boundaries);
  return Described{std::move(built->mesh), std::move(adjacency), std::move(description),
                   std::move(built->decoded.materials)};
}

Result<std::string> MeshCatalog::metadata(const std::string& id, const Caller& caller) {
  auto stored = description_of(id);
  if (!stored) return fail(std::move(stored.error()));
  if (!*stored) {
    auto description = described_anew(id, caller);
    if (!description) return fail(std::move(description.error()));
    *stored = std::move(*description);
  }
  return proto::with_state(**stored, meshes_.peek(id), prepared_.peek(adjacency_key(id)));
}

Result<void> MeshCatalog::remove(const std::string& id) {
  const auto existed = store_.remove(id);
  meshes_.erase(id);
  prepared_.erase_prefix(id + "/");
  if (!existed) return fail(existed.error());
  // Of one that is unknown too: what an earlier removal could not reach goes with the next one.
  if (prepared_files_ != nullptr && is_mesh_id(id)) prepared_files_->erase(id);
  if (!*existed) return unknown_mesh();
  return {};
}

Result<std::vector<std::string>> MeshCatalog::list(std::string_view after, std::size_t limit) {
  return store_.list(after, limit);
}

// Reads on the caller's thread and decodes on a compute worker's: a slow store must
// not keep queries on other meshes from their slots.
Result<std::shared_ptr<const Mesh>> MeshCatalog::load_mesh(const std::string& id,
                                                           const Caller& caller) {
  auto mesh = meshes_.get_or_create(
      id,
      [&]() -> Result<std::shared_ptr<const Mesh>> {
        auto built = [&]() -> Result<Built> {
          const auto file =
              step("read", Stage::load, caller, [&] { return stored_file(id, caller); });
          if (!file) return fail(file.error());
          return pool_.run(
              [&](Worker&) {
                return step("decode", Stage::load, caller,
                            [&] { return build(file->bytes, file->options, caller); });
              },
              caller);
        }();
        if (!built) return fail(std::move(built.error()));
        // Not in a compute slot: it may wait for who is making them in one.
        keep_materials(id, std::move(built->decoded.materials), caller);
        return std::move(built->mesh);
      },
      caller);
  if (!mesh) return fail(std::move(mesh.error()));
  return mesh->value;
}

Result<void> MeshCatalog::check_is_there(const AskedSurface& surface) {
  const std::string& id = surface.mesh();
  const auto known = store_.use(id);
  if (!known) return fail(known.error());
  // Damage on the disk is no reason to refuse what is whole in memory, or can be cut out of it.
  const bool is_resident = store_.is_damaged(id) && (prepared_.peek(adjacency_key(surface.key())) ||
                                                     prepared_.peek(adjacency_key(id)));
  if (*known || is_resident) return {};
  // Another server may have deleted it.
  prepared_.erase_prefix(id + "/");
  if (prepared_files_ != nullptr) prepared_files_->forget(id);
  return unknown_mesh();
}

Result<std::shared_ptr<const Adjacency>> MeshCatalog::adjacency(const std::string& id,
                                                                const Caller& caller) {
  auto whole = surface(AskedSurface(id), caller);
  if (!whole) return fail(std::move(whole.error()));
  return std::move(whole->adjacency);
}

Result<PreparedSurface> MeshCatalog::surface(const AskedSurface& surface, const Caller& caller) {
  if (auto there = check_is_there(surface); !there) return fail(std::move(there.error()));
  const auto prepared = prepared_.get_or_create(
      adjacency_key(surface.key()),
      [&]() -> Result<std::shared_ptr<const Prepared>> {
        if (surface.is_whole()) {
          auto adjacency = whole(surface.mesh(), caller);
          if (!adjacency) return fail(std::move(adjacency.error()));
          return std::make_shared<const Prepared>(PreparedSurface{std::move(*adjacency), {}});
        }
        auto cut = cut_out(surface, caller);
        if (!cut) return fail(std::move(cut.error()));
        return std::make_shared<const Prepared>(std::move(*cut));
      },
      caller);
  if (!prepared) return fail(prepared.error());
  return std::get<PreparedSurface>(*prepared->value);
}

Result<std::shared_ptr<const Adjacency>> MeshCatalog::whole(const std::string& id,
                                                            const Caller& caller) {
  auto mapped = mapped_adjacency(id, caller);
  if (mapped && *mapped == nullptr) return adjacency_anew(id, caller);
  return mapped;
}

Result<PreparedSurface> MeshCatalog::cut_out(const AskedSurface& surface, const Caller& caller) {
  const auto whole = adjacency(surface.mesh(), caller);
  if (!whole) return fail(whole.error());
  const auto file = file_faces(surface.mesh(), surface.regions().named_of_file(), caller);
  if (!file) return fail(file.error());
  // Points of lines are those of the whole.
  std::shared_ptr<const ClosestPointIndex> index;
  if (has_searched_points(surface.regions())) {
    auto built = closest_points(AskedSurface(surface.mesh()), caller);
    if (!built) return fail(std::move(built.error()));
    index = std::move(*built);
  }
  const auto cut = [&]() -> Result<PreparedSurface> {
    const Mesh& all = (*whole)->mesh();
    ComputePool::Help help(pool_, all.vertex_count() >= Team::kFewestVertices);
    const Cancel cancel = cancel_of(caller).helped_by(help.team());
    std::shared_ptr<const Mesh> left;
    PreparedSurface prepared;
    if (surface.regions().has_lines()) {
      auto mesh = cut_lines(**whole, index.get(), surface.regions(), *file, cancel);
      if (!mesh) return fail(std::move(mesh.error()));
      left = std::make_shared<const Mesh>(std::move(mesh->mesh));
      prepared.refinement = std::make_shared<const Refinement>(std::move(mesh->refinement));
    } else {
      auto mesh = proto::cut_regions(all, surface.regions(), *file, cancel);
      if (!mesh) return fail(std::move(mesh.error()));
      left = std::make_shared<const Mesh>(std::move(*mesh));
    }
    auto adjacency = prepare(std::move(left), pool_, caller);
    if (!adjacency) return fail(std::move(adjacency.error()));
    prepared.adjacency = std::move(*adjacency);
    return prepared;
  };
  return pool_.run([&](Worker&) { return step("cut", Stage::prepare, caller, cut); }, caller);
}

Result<std::shared_ptr<const Adjacency>> MeshCatalog::mapped_adjacency(const std::string& id,
                                                                       const Caller& caller) {
  if (prepared_files_ == nullptr) return nullptr;
  const Timed timed(caller, Stage::load);
  auto found = prepared_files_->find(id, std::cref(caller));
  if (!found) return fail(caller.why_stopped());
  if (*found) metrics_.mesh_step("map", timed.so_far().count());
  return found;
}

void MeshCatalog::keep_prepared(const std::string& id,
                                const std::shared_ptr<const Adjacency>& adjacency) {
  if (prepared_files_ == nullptr) return;
  prepared_files_->keep(id, adjacency);
  // Whoever has deleted it meanwhile has seen no file to erase.
  if (const auto stored = store_.is_stored(id); stored && !*stored) prepared_files_->erase(id);
}

Result<std::shared_ptr<const Adjacency>> MeshCatalog::adjacency_anew(const std::string& id,
                                                                     const Caller& caller) {
  auto mesh = load_mesh(id, caller);
  if (!mesh) return fail(std::move(mesh.error()));
  auto adjacency = pool_.run(
      [&](Worker&) {
        return step("prepare", Stage::prepare, caller,
                    [&] { return prepare(std::move(*mesh), pool_, caller); });
      },
      caller);
  if (adjacency) keep_prepared(id, *adjacency);
  return adjacency;
}

Result<std::shared_ptr<const ClosestPointIndex>> MeshCatalog::closest_points(
    const AskedSurface& surface, const Caller& caller) {
  const auto mesh = this->surface(surface, caller);
  if (!mesh) return fail(mesh.error());
  const auto prepared = prepared_.get_or_create(
      closest_points_key(surface.key()),
      [&] {
        return pool_.run(
            [&](Worker&) -> Result<std::shared_ptr<const Prepared>> {
              auto index = step("index", Stage::prepare, caller, [&] {
                return ClosestPointIndex::build(mesh->adjacency, cancel_of(caller));
              });
              if (!index) return fail(std::move(index.error()));
              return std::make_shared<const Prepared>(std::move(*index));
            },
            caller);
      },
      caller);
  if (!prepared) return fail(prepared.error());
  return std::get<std::shared_ptr<const ClosestPointIndex>>(*prepared->value);
}

}  // namespace geodesic::server
