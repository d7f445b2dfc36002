// What makes a shape sound, however it was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "proto/region/region.h"

namespace geodesic::proto {

// Errors: value_out_of_range.
[[nodiscard]] Result<Shape> shape_of_faces(std::vector<FaceRange> ranges, std::string parameter);
// `number`: which of the ranges it is, for errors. Errors: value_out_of_range.
[[nodiscard]] Result<FaceRange> face_range(std::uint64_t first, std::uint64_t last,
                                           std::size_t number, const std::string& parameter);
// Errors: value_out_of_range.
[[nodiscard]] Result<Shape> label_shape(std::string attribute, double value, std::string parameter);
// Errors: value_out_of_range.
[[nodiscard]] Result<Shape> sphere_shape(Vec3 center, double radius, std::string parameter);
// Errors: value_out_of_range.
[[nodiscard]] Result<Shape> box_shape(Vec3 min, Vec3 max, std::string parameter);

// Errors: value_out_of_range (too few points, an offset).
[[nodiscard]] Result<Shape> inside_shape(std::vector<PointRequest> points, std::string parameter);
[[nodiscard]] Result<Wall> wall_through(std::vector<PointRequest> points, std::string parameter);

}  // namespace geodesic::proto
