#include "proto/picture/view.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <system_error>

namespace geodesic::proto {
namespace {

bool parse_degrees(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::abs(value) <= 360;
}

}  // namespace

Result<View> parse_view(std::string_view text) {
  struct Named {
    std::string_view name;
    View view;
  };
  static constexpr Named kNamed[] = {{"corner", {30, 20}}, {"front", {0, 0}},  {"back", {180, 0}},
                                     {"right", {90, 0}},   {"left", {-90, 0}}, {"top", {0, 90}},
                                     {"bottom", {0, -90}}};
  for (const Named& named : kNamed) {
    if (named.name == text) return named.view;
  }
  View view;
  const std::size_t comma = text.find(',');
  if (comma != text.npos && parse_degrees(text.substr(0, comma), view.azimuth) &&
      parse_degrees(text.substr(comma + 1), view.elevation)) {
    return view;
  }
  return fail(ErrorCode::value_out_of_range,
              "view is corner, front, back, left, right, top, bottom, or azimuth,elevation in "
              "degrees",
              "view");
}

View view_for(const Mesh& mesh) {
  const Vec3 size = mesh.box().max - mesh.box().min;
  const double flat = 1e-3 * std::max({size.x, size.y, size.z});
  if (size.z <= flat) return {0, 0};
  if (size.y <= flat) return {0, 90};
  if (size.x <= flat) return {90, 0};
  return {30, 20};
}

Frame frame_of(const View& view) {
  const double azimuth = view.azimuth * 3.141592653589793 / 180;
  const double elevation = view.elevation * 3.141592653589793 / 180;
  Frame frame;
  frame.right = {std::cos(azimuth), 0, -std::sin(azimuth)};
  frame.towards = {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                   std::cos(azimuth) * std::cos(elevation)};
  frame.up = cross(frame.towards, frame.right);
  return frame;
}

}  // namespace geodesic::proto
