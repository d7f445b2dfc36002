#include "server/query/far_points.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <variant>

#include "proto/wire/number.h"

namespace geodesic::server {
namespace {

constexpr int kDigits = 3;

std::string text_of(double length) {
  std::string text;
  proto::append_number(text, length, kDigits);
  return text;
}

// The far points of one parameter.
struct FarPoints {
  std::string_view parameter;
  std::size_t asked = 0;
  std::size_t far = 0;
  double farthest = 0;  // mesh units
};

// Of several points in JSON, `from[3]` is one of `from`.
std::string_view parameter_of(const proto::PointRequest& request) {
  return std::string_view(request.parameter).substr(0, request.parameter.find('['));
}

std::string sentence(const FarPoints& points, double limit) {
  std::string text;
  if (points.asked == 1) {
    text = "The point of " + std::string(points.parameter) + " is " + text_of(points.farthest);
  } else {
    text = std::to_string(points.far) + " of " + std::to_string(points.asked) + " points of " +
           std::string(points.parameter) + (points.far == 1 ? " is " : " are up to ") +
           text_of(points.farthest);
  }
  return text + " away from the surface, more than " + text_of(limit) +
         ", which is 5 % of the mesh's size. Check units and axes, or give max_snap to have such "
         "points refused.";
}

}  // namespace

void warn_of_far_points(const Mesh& mesh, const std::vector<proto::PointRequest>& asked,
                        const std::vector<proto::ResolvedPoint>& found,
                        std::vector<std::string>& warnings) {
  const double limit = kFarPart * distance(mesh.box().min, mesh.box().max);
  std::vector<FarPoints> all;  // a query has few parameters that are points
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const std::string_view parameter = parameter_of(asked[i]);
    auto points = std::find_if(all.begin(), all.end(),
                               [&](const FarPoints& some) { return some.parameter == parameter; });
    if (points == all.end()) points = all.insert(points, FarPoints{parameter});
    ++points->asked;
    const auto* space = std::get_if<proto::SpaceRequest>(&asked[i].where);
    if (space == nullptr || space->max_snap || found[i].snap_distance <= limit) continue;
    ++points->far;
    points->farthest = std::max(points->farthest, found[i].snap_distance);
  }
  for (const FarPoints& points : all) {
    if (points.far > 0) warnings.push_back(sentence(points, limit));
  }
}

}  // namespace geodesic::server
