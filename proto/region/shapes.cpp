#include "proto/region/shapes.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/mesh.h"

namespace geodesic::proto {
namespace {

Result<void> check_place(Vec3 place, const std::string& parameter) {
  for (const double coordinate : {place.x, place.y, place.z}) {
    if (!(std::abs(coordinate) <= Mesh::kMaxCoordinate)) {
      return fail(ErrorCode::value_out_of_range, "a coordinate is too large", parameter);
    }
  }
  return {};
}

// `least`: so many points at least.
Result<void> check_line(const std::vector<PointRequest>& points, std::size_t least,
                        const char* too_few, const std::string& parameter) {
  if (points.size() < least) {
    return fail(ErrorCode::value_out_of_range, too_few, parameter);
  }
  for (const PointRequest& point : points) {
    if (point.offset != 0) {
      return fail(ErrorCode::value_out_of_range, "only sources of a field can have an offset",
                  point.parameter + ".offset");
    }
  }
  return {};
}

}  // namespace

Result<Shape> inside_shape(std::vector<PointRequest> points, std::string parameter) {
  constexpr std::size_t kFewest = 3;
  if (auto sound =
          check_line(points, kFewest, "what has an inside goes through three points or more",
                     parameter + ".inside");
      !sound) {
    return fail(std::move(sound.error()));
  }
  return Shape{InsideShape{std::move(points)}, std::move(parameter)};
}

Result<Wall> wall_through(std::vector<PointRequest> points, std::string parameter) {
  if (auto sound = check_line(points, 2, "a wall goes through two points or more", parameter);
      !sound) {
    return fail(std::move(sound.error()));
  }
  return Wall{std::move(points), std::move(parameter)};
}

Result<Shape> shape_of_faces(std::vector<FaceRange> ranges, std::string parameter) {
  if (ranges.empty()) {
    return fail(ErrorCode::value_out_of_range, "there is no face in this list",
                std::move(parameter));
  }
  return Shape{std::move(ranges), std::move(parameter)};
}

Result<FaceRange> face_range(std::uint64_t first, std::uint64_t last, std::size_t number,
                             const std::string& parameter) {
  if (first <= last) return FaceRange{first, last};
  return fail(ErrorCode::value_out_of_range,
              "a range of faces ends at " + std::to_string(last) + ", before it begins at " +
                  std::to_string(first),
              parameter + ".faces[" + std::to_string(number) + "]");
}

Result<Shape> label_shape(std::string attribute, double value, std::string parameter) {
  constexpr std::size_t kMostBytes = 200;
  if (attribute.empty() || attribute.size() > kMostBytes) {
    return fail(ErrorCode::value_out_of_range,
                "the name of an attribute has 1 to 200 bytes, as _SEG has four",
                parameter + ".label");
  }
  if (std::abs(value) > std::numeric_limits<float>::max()) {
    return fail(ErrorCode::value_out_of_range, "no label is so great: they are floats or integers",
                parameter + ".label");
  }
  return Shape{LabelShape{std::move(attribute), value}, std::move(parameter)};
}

Result<Shape> sphere_shape(Vec3 center, double radius, std::string parameter) {
  if (auto usable = check_place(center, parameter + ".sphere.center"); !usable) {
    return fail(std::move(usable.error()));
  }
  if (!(radius >= 0)) {
    return fail(ErrorCode::value_out_of_range, "a radius is not negative",
                parameter + ".sphere.radius");
  }
  return Shape{SphereShape{center, radius}, std::move(parameter)};
}

Result<Shape> box_shape(Vec3 min, Vec3 max, std::string parameter) {
  if (auto usable = check_place(min, parameter + ".box.min"); !usable) {
    return fail(std::move(usable.error()));
  }
  if (auto usable = check_place(max, parameter + ".box.max"); !usable) {
    return fail(std::move(usable.error()));
  }
  if (!(min.x <= max.x && min.y <= max.y && min.z <= max.z)) {
    return fail(ErrorCode::value_out_of_range,
                "a box has no coordinate that is less in max than in min", parameter + ".box");
  }
  return Shape{BoxShape{min, max}, std::move(parameter)};
}

}  // namespace geodesic::proto
