// Weights and labels of faces out of an attribute of a glTF file's vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/mesh/face_numbers.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

// What a face gets of the numbers at its corners.
enum class FaceNumber : std::uint8_t {
  weight,  // their mean; each is a float, and has to be a weight
  label,   // the one that all three corners have, to the last digit; else NaN
};

// Of each face; integers that are normalised are divided by their greatest. What a primitive's
// Draco data has is read from there. `bytes` are those of a GLB or glTF file that has been decoded
// with these options. Errors: those of `decode_gltf`; value_out_of_range, of `weight_attribute` if
// these are weights and else of nothing, where a primitive of triangles has no attribute of that
// name (the message lists those that it has), where it is not one number a vertex for all vertices,
// or cannot be read from the primitive's Draco data, or where the number at a corner is no weight.
[[nodiscard]] Result<FaceNumbers> read_face_numbers(std::span<const std::byte> bytes,
                                                    const DecodeLimits& limits,
                                                    const ImportOptions& options,
                                                    const std::string& attribute, FaceNumber which);

}  // namespace geodesic::proto
