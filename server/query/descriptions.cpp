// What is kept about a stored mesh beside its file: its metadata, its name in them, and how the
// file is to be read.
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "proto/mesh/metadata.h"
#include "server/query/mesh_catalog.h"
#include "server/store/mesh_id.h"

namespace geodesic::server {

Result<std::string> MeshCatalog::rename(const std::string& id, const std::string& name,
                                        const Caller& caller) {
  return set_name(id, name, false, caller);
}

Result<std::string> MeshCatalog::set_name(const std::string& id, const std::string& name,
                                          bool only_first, const Caller& caller) {
  // An upload that was cut off has no description yet.
  if (const auto described = metadata(id, caller); !described) return fail(described.error());
  {
    const std::lock_guard lock(descriptions_mutex_);
    const auto description = description_of(id, /*afresh=*/true);
    if (!description) return fail(description.error());
    if (!*description) return unknown_mesh();
    if (!only_first || !proto::name_in(**description)) {
      const auto named = proto::with_name(**description, name);
      if (!named) return fail(named.error());
      if (auto put = store_.put_metadata(id, *named); !put) return fail(std::move(put.error()));
    }
  }
  return metadata(id, caller);
}

Result<std::optional<std::string>> MeshCatalog::description_of(const std::string& id, bool afresh) {
  auto stored = afresh ? store_.get_metadata_afresh(id) : store_.get_metadata(id);
  if (!stored || !*stored) return stored;
  if ((*stored)->size() > proto::kMostDescriptionBytes) {  // by an older version
    if (!has_options(id)) return std::nullopt;             // to be described anew
    auto bounded = proto::without_parts(**stored);
    if (!bounded) return std::nullopt;
    // So that the next one need not do it; if it fails, the next one does.
    (void)store_.put_metadata(id, *bounded);
    *stored = std::move(*bounded);
  }
  const auto options = proto::import_options_of(**stored);
  if (!options || !is_of_options(id, proto::canonical_text(*options))) return std::nullopt;
  return stored;
}

Result<proto::ImportOptions> MeshCatalog::options_of(const std::string& id) {
  if (!has_options(id)) return proto::ImportOptions{};
  const auto description = description_of(id);
  if (!description) return fail(description.error());
  // Cut off between the two files, an upload has left bytes of which nobody knows how
  // they were to be read.
  if (!*description) return unknown_mesh();
  return proto::import_options_of(**description);
}

// An upload that was cut off between the two files has left the bytes alone.
Result<std::string> MeshCatalog::described_anew(const std::string& id, const Caller& caller) {
  if (has_options(id)) return unknown_mesh();
  const auto file = stored_file(id, caller);
  if (!file) return fail(file.error());
  auto described =
      pool_.run([&](Worker&) { return describe(id, file->bytes, file->options, caller); }, caller);
  if (!described) return fail(std::move(described.error()));
  if (auto put = store_.put_metadata(id, described->description); !put) return fail(put.error());
  return std::move(described->description);
}

}  // namespace geodesic::server
