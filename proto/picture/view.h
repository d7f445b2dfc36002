// From where a picture is seen.
#pragma once

#include <string_view>

#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/mesh/mesh.h"

namespace geodesic::proto {

// Degrees: the eye's azimuth round the y axis (0: on +z, 90: on +x), and its
// elevation over the xz plane. glTF's y is up.
struct View {
  double azimuth = 30;
  double elevation = 20;
};

// A name (front, back, left, right, top, bottom, corner) or "azimuth,elevation".
// Errors: value_out_of_range with parameter "view".
[[nodiscard]] Result<View> parse_view(std::string_view text);

// Straight at a mesh that is flat along an axis, else from the corner.
[[nodiscard]] View view_for(const Mesh& mesh);

// The frame of the eye: x to the right, y up, z towards the eye.
struct Frame {
  Vec3 right, up, towards;
  [[nodiscard]] Vec3 seen(Vec3 p) const { return {dot(right, p), dot(up, p), dot(towards, p)}; }
};
[[nodiscard]] Frame frame_of(const View& view);

}  // namespace geodesic::proto
