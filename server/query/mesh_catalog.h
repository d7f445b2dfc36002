// The meshes of this process: uploaded, kept in the store, and made ready for
// queries in caches of their own.
//
//   store            bytes and descriptions of every mesh
//   mesh cache       decoded meshes
//   adjacency cache  prepared adjacency and, once asked for, the index that finds
//                    closest points
//   prepared files   if there is a directory for them: prepared adjacency with its mesh
//
// What a cache has dropped comes back from these files, or from the store. However many ask for it
// at once, it is made once. All methods may be called from any thread but a compute worker: making
// runs in a compute slot, and waits for one.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/locate/closest_point.h"
#include "core/mesh/mesh.h"
#include "core/refine/refinement.h"
#include "core/surface/adjacency.h"
#include "proto/gltf/weights.h"
#include "proto/gltf_file/annotation.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/mesh/face_materials.h"
#include "proto/region/costs.h"
#include "proto/region/file_faces.h"
#include "proto/region/region.h"
#include "proto/wire/import_options.h"
#include "server/base/caller.h"
#include "server/base/current.h"
#include "server/base/lru_cache.h"
#include "server/base/timed.h"
#include "server/base/turns.h"
#include "server/compute/pool.h"
#include "server/decoder/processes.h"
#include "server/metrics/metrics.h"
#include "server/prepared/prepared_files.h"
#include "server/query/uploaded_gltf.h"
#include "server/store/mesh_store.h"

namespace geodesic::server {

struct CatalogLimits {
  proto::DecodeLimits decode;
  std::uint64_t mesh_cache_bytes = std::uint64_t{1} << 30;
  std::uint64_t adjacency_cache_bytes = std::uint64_t{2} << 30;
  DecoderProcesses::Limits decoder;
};

// A surface made ready for queries. Where lines have split faces, which parts of them its faces
// are; null elsewhere.
struct PreparedSurface {
  std::shared_ptr<const Adjacency> adjacency;
  std::shared_ptr<const Refinement> refinement;
};

// What a query is about: a mesh, or what regions leave of it; and what ways over it cost.
class AskedSurface {
 public:
  explicit AskedSurface(std::string mesh, proto::Regions regions = {}, proto::Costs costs = {});

  [[nodiscard]] const std::string& mesh() const { return mesh_; }  // its id
  [[nodiscard]] const proto::Regions& regions() const { return regions_; }
  [[nodiscard]] bool is_whole() const { return regions_.is_everything(); }
  // What caches know it by: the id, and for a part of the surface a digest of its regions.
  [[nodiscard]] const std::string& key() const { return key_; }
  [[nodiscard]] const proto::Costs& costs() const { return costs_; }
  // What caches know its fields by: the key, and with costs a digest of them.
  [[nodiscard]] const std::string& field_key() const { return field_key_; }

 private:
  std::string mesh_;
  proto::Regions regions_;
  proto::Costs costs_;
  std::string key_;
  std::string field_key_;
};

class MeshCatalog {
 public:
  struct Upload {
    std::string id;
    std::string metadata;  // JSON
    bool created;          // false: it was known already
  };

  // Without `decoders`, files are decoded in this process.
  MeshCatalog(MeshStore& store, ComputePool& pool, const CatalogLimits& limits, Metrics& metrics,
              DecoderProcesses* decoders = nullptr);

  // Prepared meshes are kept there, and had from there instead of being prepared again. It must
  // outlive this. Before the first mesh.
  void keep_prepared_in(PreparedFiles& files) { prepared_files_ = &files; }

  // For meshes to come; what is over a cache's new budget goes at once.
  void set_limits(const CatalogLimits& limits);

  // Decodes, checks and stores a file. On any error nothing of it remains. `name`: what the mesh
  // is called (proto/wire/mesh_name.h), if it has no name yet. A mesh that is stored already keeps
  // having none where the name cannot be written.
  [[nodiscard]] Result<Upload> add(std::string bytes, const proto::ImportOptions& options,
                                   const Caller& caller, const std::string& name = {});
  // Gives a mesh another name, or none; returns its metadata. Errors: mesh_unknown and the
  // store's.
  [[nodiscard]] Result<std::string> rename(const std::string& id, const std::string& name,
                                           const Caller& caller);
  // The mesh file in a form, to be added (mesh_form.h). In a compute slot, where files
  // are decoded. Errors besides: those of decoding; overloaded, draining, cancelled.
  [[nodiscard]] Result<FormFile> file_of_form(std::string_view body, std::string_view boundary,
                                              const Caller& caller);
  // The metadata as JSON, with its present state. Errors: mesh_unknown.
  [[nodiscard]] Result<std::string> metadata(const std::string& id, const Caller& caller);
  // The uploaded bytes. Errors: mesh_unknown and the store's.
  [[nodiscard]] Result<std::string> source(const std::string& id);
  // The bytes of a GLB or glTF file, and how they get these attributes. Errors besides: those of
  // proto::annotate_gltf; overloaded, draining, cancelled.
  [[nodiscard]] Result<UploadedGltf> uploaded_gltf(
      const std::string& id, const std::vector<proto::VertexAttribute>& attributes,
      const Caller& caller);
  // Weights or labels of the faces of a GLB or glTF file, by an attribute of its vertices; kept
  // with what is prepared of the mesh. Errors besides: those of proto::read_face_numbers;
  // overloaded, draining, cancelled.
  using Numbers = std::shared_ptr<const proto::FaceNumbers>;
  [[nodiscard]] Result<Numbers> face_numbers(const std::string& id, const std::string& attribute,
                                             proto::FaceNumber which, const Caller& caller);
  // The uploaded bytes as a file; null where they cannot be had as one. Errors besides: cancelled.
  [[nodiscard]] Result<std::shared_ptr<const ReplyFile>> source_file(const std::string& id,
                                                                     const Caller& caller) {
    return store_.open_source(id, std::cref(caller));
  }
  // Errors: mesh_unknown and the store's.
  [[nodiscard]] Result<void> remove(const std::string& id);
  // Up to `limit` ids after `after`, ascending. Errors: the store's.
  [[nodiscard]] Result<std::vector<std::string>> list(std::string_view after, std::size_t limit);
  [[nodiscard]] std::size_t size() const { return store_.size(); }
  [[nodiscard]] bool contains(std::string_view id) const { return store_.contains(id); }
  // Whether a mesh is there; it then counts as used, for a store that evicts.
  [[nodiscard]] bool use(const std::string& id) { return store_.use(id).value_or(false); }
  // How the store is: for readiness, metrics and status. From memory.
  [[nodiscard]] Result<void> store_health() const { return store_.health(); }
  // Asks the store now; `store_unavailable`.
  [[nodiscard]] Result<void> check_store() { return store_.check(); }
  [[nodiscard]] StoreStats store_stats() const { return store_.stats(); }

  // The prepared adjacency, built if it is not there. Errors: mesh_unknown,
  // the store's (mesh_store.h), overloaded, draining, cancelled.
  [[nodiscard]] Result<std::shared_ptr<const Adjacency>> adjacency(const std::string& id,
                                                                   const Caller& caller);
  // The same of the surface that is asked about: of a part of a mesh, a mesh of its own in the
  // numbers of the whole. Errors besides: those of proto::cut_regions and cut_lines.
  [[nodiscard]] Result<PreparedSurface> surface(const AskedSurface& surface, const Caller& caller);
  // What a mesh's file calls its faces by, as far as it is named. Which face has which material is
  // known from the last decoding, or else decoded; parts are, where the metadata does not list all
  // that have numbers. Errors: those of `metadata`, `adjacency` and `face_numbers`;
  // value_out_of_range where a file without attributes is asked for labels.
  [[nodiscard]] Result<proto::FileFaces> file_faces(const std::string& id,
                                                    const proto::NamedOfFile& named,
                                                    const Caller& caller);
  [[nodiscard]] Result<std::shared_ptr<const ClosestPointIndex>> closest_points(
      const AskedSurface& surface, const Caller& caller);

  [[nodiscard]] DecoderProcesses::Stats decoder_stats() const {
    return decoders_ != nullptr ? decoders_->stats() : DecoderProcesses::Stats{};
  }
  [[nodiscard]] PreparedFiles::Stats prepared_stats() const {
    return prepared_files_ != nullptr ? prepared_files_->stats() : PreparedFiles::Stats{};
  }
  [[nodiscard]] CacheStats mesh_cache() const { return meshes_.stats(); }
  [[nodiscard]] CacheStats adjacency_cache() const { return prepared_.stats(); }
  [[nodiscard]] std::vector<CacheEntry> cached_meshes(std::size_t most) const {
    return meshes_.entries(most);
  }
  [[nodiscard]] std::vector<CacheEntry> cached_adjacency(std::size_t most) const {
    return prepared_.entries(most);
  }

 private:
  using Materials = std::shared_ptr<const proto::FaceMaterials>;
  using Parts = std::shared_ptr<const proto::ToldParts>;
  using Prepared = std::variant<PreparedSurface, std::shared_ptr<const ClosestPointIndex>,
                                Materials, Parts, Numbers>;

  struct Described {
    std::shared_ptr<const Mesh> mesh;
    std::shared_ptr<const Adjacency> adjacency;
    std::string description;  // JSON
    proto::FaceMaterials materials;
  };

  struct Built {
    proto::DecodedMesh decoded;  // without its soup
    std::shared_ptr<const Mesh> mesh;
  };

  // Stores the bytes of a known mesh again, unless those that are there are surely they.
  [[nodiscard]] Result<void> make_sure(const std::string& id, std::string_view bytes);
  [[nodiscard]] Result<proto::DecodedMesh> decode(const std::string& bytes,
                                                  const proto::ImportOptions& options,
                                                  const Caller& caller);
  struct StoredFile {
    std::string bytes;
    proto::ImportOptions options;
    std::shared_ptr<const void> turn;
  };
  // An uploaded file, and how it is to be read. To be let go of before anything is waited for that
  // is made of other files. Errors: mesh_unknown and the store's; those of Turns.
  [[nodiscard]] Result<StoredFile> stored_file(const std::string& id, const Caller& caller);
  template <class Kept, class Make>
  [[nodiscard]] Result<std::shared_ptr<const Kept>> kept(const std::string& key,
                                                         const Caller& caller, const Make& make);
  // Keeps them for queries that name one, if there are any.
  void keep_materials(const std::string& id, proto::FaceMaterials materials, const Caller& caller);
  [[nodiscard]] Result<proto::DecodedMesh> decode_stored(const std::string& id,
                                                         const Caller& caller);
  // Those that the metadata does not list, too.
  [[nodiscard]] Result<Parts> parts(const std::string& id, const Caller& caller);
  [[nodiscard]] Result<Materials> materials(const std::string& id, const Caller& caller);
  [[nodiscard]] Result<Numbers> face_labels(const std::string& id, const std::string& description,
                                            const std::string& attribute, const Caller& caller);
  [[nodiscard]] Result<Built> build(const std::string& bytes, const proto::ImportOptions& options,
                                    const Caller& caller);
  [[nodiscard]] Result<Described> describe(const std::string& id, const std::string& bytes,
                                           const proto::ImportOptions& options,
                                           const Caller& caller);
  // Gives a mesh another name, and returns its metadata; with `only_first`, only if it has none
  // yet. Errors: mesh_unknown and the store's.
  [[nodiscard]] Result<std::string> set_name(const std::string& id, const std::string& name,
                                             bool only_first, const Caller& caller);
  // What is kept about a stored mesh, or nothing if that is not there, cannot be read, or
  // tells of other options than those in the mesh's id. `afresh`: where other servers use the
  // store, as it is there now.
  [[nodiscard]] Result<std::optional<std::string>> description_of(const std::string& id,
                                                                  bool afresh = false);
  // How a stored mesh is to be read. Errors: mesh_unknown and the store's.
  [[nodiscard]] Result<proto::ImportOptions> options_of(const std::string& id);
  // Does one step in making a mesh usable, and notes how long it took.
  template <class Work>
  [[nodiscard]] auto step(std::string_view name, Stage stage, const Caller& caller, Work&& work) {
    const Timed timed(caller, stage);
    auto result = work();
    metrics_.mesh_step(name, timed.so_far().count());
    return result;
  }
  [[nodiscard]] Result<std::shared_ptr<const Mesh>> load_mesh(const std::string& id,
                                                              const Caller& caller);
  // Out of the prepared files; null if it is not there. Errors: cancelled.
  [[nodiscard]] Result<std::shared_ptr<const Adjacency>> mapped_adjacency(const std::string& id,
                                                                          const Caller& caller);
  void keep_prepared(const std::string& id, const std::shared_ptr<const Adjacency>& adjacency);
  // Reads, decodes and prepares.
  [[nodiscard]] Result<std::shared_ptr<const Adjacency>> adjacency_anew(const std::string& id,
                                                                        const Caller& caller);
  [[nodiscard]] Result<std::string> described_anew(const std::string& id, const Caller& caller);
  // Forgets a mesh that is not stored any more. Errors: mesh_unknown, the store's.
  [[nodiscard]] Result<void> check_is_there(const AskedSurface& surface);
  // What is in a prepared file, or else made of the upload.
  [[nodiscard]] Result<std::shared_ptr<const Adjacency>> whole(const std::string& id,
                                                               const Caller& caller);
  // Cuts a part out of the whole and prepares it.
  [[nodiscard]] Result<PreparedSurface> cut_out(const AskedSurface& surface, const Caller& caller);

  MeshStore& store_;
  ComputePool& pool_;
  // At having a stored file in memory: whoever has read one may wait for a compute slot before it
  // is decoded. So nobody waits for a turn in a slot.
  Turns file_turns_;
  Metrics& metrics_;
  DecoderProcesses* const decoders_;
  PreparedFiles* prepared_files_ = nullptr;
  Current<proto::DecodeLimits> decode_limits_;
  // What an index counts at least, so that there are never more than kMostIndexes.
  std::atomic<std::size_t> least_index_bytes_;
  LruCache<Mesh> meshes_;
  LruCache<Prepared> prepared_;
  LruCache<Upload> uploads_;  // keeps nothing: one upload at a time of the same bytes
  // Held from reading a description to writing it with another name, or again.
  std::mutex descriptions_mutex_;
};

}  // namespace geodesic::server
