// How a client wants its file read: the parameters of an upload. Whatever differs
// from the default makes another mesh of the same bytes, with an id of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "core/mesh/triangle_soup.h"
#include "proto/wire/parameters.h"

namespace geodesic::proto {

// Of the name of a scene or a node that a client may choose.
inline constexpr std::size_t kMostChosenNameBytes = 512;

enum class UpAxis : std::uint8_t { x, y, z };

struct ImportOptions {
  // A scene or a node of a glTF file: digits are an index, anything else a name.
  std::optional<std::string> scene;
  std::optional<std::string> node;  // only what this node and its children draw
  // Vertices at most so far apart become one, in mesh units after scaling; 0: those
  // at the same position.
  double weld_tolerance = 0;
  Weld weld = Weld::by_position;
  // The axis that points up in the file; positions are turned to have y up.
  UpAxis up = UpAxis::y;
  double scale = 1;  // all positions times this

  friend bool operator==(const ImportOptions&, const ImportOptions&) = default;
};

// `scene`, `node`, `weld`, `up` and `scale`. Errors: bad_syntax, naming the parameter.
[[nodiscard]] Result<ImportOptions> read_import_options(Parameters& parameters);

// What differs from the defaults as a JSON object, its members in one order and its
// numbers in one form; empty for none. Equal options have equal texts. As the body
// of `Parameters::from_json` it gives the options back.
[[nodiscard]] std::string canonical_text(const ImportOptions& options);

// Turns and scales positions. A turn is exact: z up becomes (x, z, -y), and x up
// becomes (-y, x, z).
void place(TriangleSoup& soup, const ImportOptions& options);

}  // namespace geodesic::proto
