// Weights of faces out of an attribute of a glTF file's vertices.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

struct FaceWeights {
  std::vector<double> by_face;  // of the file, in the order of decoding
};

// The mean of the attribute at the three corners of each face; integers that are normalised are
// divided by their greatest. What a primitive's Draco data has is read from there. `bytes` are
// those of a GLB or glTF file that has been decoded with these options. Errors: those of
// `decode_gltf`; value_out_of_range, always of `weight_attribute`, where a primitive of triangles
// has no attribute of that name (the message lists those that it has), where it is not one number a
// vertex for all vertices, or cannot be read from the primitive's Draco data, or where the number
// at a corner is no weight.
[[nodiscard]] Result<FaceWeights> read_face_weights(std::span<const std::byte> bytes,
                                                    const DecodeLimits& limits,
                                                    const ImportOptions& options,
                                                    const std::string& attribute);

}  // namespace geodesic::proto
