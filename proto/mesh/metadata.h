// What is known of a stored mesh, and its JSON: made once at upload, kept beside
// the bytes, and completed with what changes (`state`, `prepared`) when asked for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/surface/adjacency.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

// What a description takes at most, so that any number of them can be read, listed and sent.
inline constexpr std::size_t kMostDescriptionBytes = std::size_t{2} << 20;

// Of a mesh's boundary loops, those that are told of: the longest ones.
inline constexpr std::size_t kMostBoundaries = 100;

// A loop of the boundary. They are numbered as sources `boundary:K` are.
struct ToldBoundary {
  double length = 0;  // mesh units
  std::uint64_t edges = 0;
  std::uint64_t vertex = 0;  // a source vertex on it
  bool is_closed = true;
};

// Of a part: its faces, which are in a row, and its name as clients read it.
struct ToldPart {
  std::uint64_t first_face;
  std::uint64_t face_count;
  std::string name;
};

struct ToldParts {
  std::vector<ToldPart> parts;    // the first ones of the file
  std::uint64_t total = 0;        // of the file
  bool has_no_materials = false;  // it says so; older descriptions say nothing of materials

  // Whether there are more that have numbers.
  [[nodiscard]] bool are_missing() const {
    return parts.size() < std::min<std::uint64_t>(total, kMostParts);
  }
  [[nodiscard]] std::size_t bytes() const;
};

// The part that changes by a `name` alone, as a JSON object of kMostDescriptionBytes at most: of
// very many parts and materials the first ones, and findings that say how many are left out. Of
// `decoded` all but the soup; of `boundaries` the first kMostBoundaries.
[[nodiscard]] std::string describe_mesh(std::string_view id, std::uint64_t bytes,
                                        const ImportOptions& options, const DecodedMesh& decoded,
                                        const Adjacency& adjacency,
                                        std::span<const ToldBoundary> boundaries = {});

// The options that such an object tells of. Errors: store_corrupt.
[[nodiscard]] Result<ImportOptions> import_options_of(const std::string& description);

// A description as an older version may have stored it, over kMostDescriptionBytes: without its
// parts. Errors: store_corrupt.
[[nodiscard]] Result<std::string> without_parts(const std::string& description);

// That object with the mesh's `name`, in place of one that it has; an empty name takes that away.
// Errors: store_corrupt.
[[nodiscard]] Result<std::string> with_name(const std::string& description, std::string_view name);

// The name that it has, if any.
[[nodiscard]] std::optional<std::string> name_in(const std::string& description);

// The format that the file was in; empty if it is not told.
[[nodiscard]] std::string format_in(const std::string& description);

// What it tells of the file's parts: fewer than kMostParts, where all of them would make it too
// long. Errors: store_corrupt.
[[nodiscard]] Result<ToldParts> parts_in(const std::string& description);

// The first kMostParts, however long their names are.
[[nodiscard]] ToldParts told_parts(const DecodedMesh& decoded);

// That object, whose options have been read, with `state` and `prepared` added. Takes no longer
// than a copy. Errors: store_corrupt.
[[nodiscard]] Result<std::string> with_state(const std::string& description, bool resident,
                                             bool prepared);

}  // namespace geodesic::proto
