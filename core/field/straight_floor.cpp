#include "core/field/straight_floor.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/team.h"
#include "core/base/tolerances.h"

namespace geodesic {

StraightLinesFrom::StraightLinesFrom(const Mesh& mesh, const SurfacePoint& source) {
  const auto positions = mesh.positions();
  if (source.at_vertex()) {
    corner_ = positions[source.vertex];
    return;
  }
  const Triangle& t = mesh.faces()[source.face];
  corner_ = positions[t[0]];
  beyond_ =
      source.bary[1] * (positions[t[1]] - corner_) + source.bary[2] * (positions[t[2]] - corner_);
}

bool StraightLinesFrom::raise(Vec3 place, double& distance) const {
  const double straight2 = squared_to(place);
  if (!(distance * distance < straight2)) return false;
  const double straight = std::sqrt(straight2);
  const bool is_below = distance < (1 - tolerance::kSamePath) * straight;
  distance = straight;
  return is_below;
}

namespace {

class StraightLines {
 public:
  StraightLines(const Mesh& mesh, Field& field)
      : positions_(mesh.positions()), distance_(field.distance.doubles()), field_(field) {
    for (const Source& source : field.sources) lines_.emplace_back(mesh, source.point);
  }

  // Both say whether any was below by more than rounding.
  bool raise(std::uint32_t v) const {
    const std::uint32_t number = field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
    if (number >= lines_.size()) return false;  // not reached
    const double offset = field_.sources[number].offset;
    double over_surface = distance_[v] - offset;
    const double before = over_surface;
    const bool is_below = lines_[number].raise(positions_[v], over_surface);
    if (over_surface != before) distance_[v] = offset + over_surface;
    return is_below;
  }
  bool raise_all(std::uint32_t begin, std::uint32_t end) const {
    bool is_any_below = false;
    if (lines_.size() != 1 || field_.sources[0].offset != 0) {
      for (std::uint32_t v = begin; v < end; ++v) is_any_below = raise(v) || is_any_below;
      return is_any_below;
    }
    // The usual case: one source without an offset. Hardly any distance has to be raised.
    for (std::uint32_t v = begin; v < end; ++v) {
      if (distance_[v] * distance_[v] < lines_[0].squared_to(positions_[v])) [[unlikely]]
        is_any_below = raise(v) || is_any_below;
    }
    return is_any_below;
  }

 private:
  std::span<const Vec3> positions_;
  std::span<double> distance_;
  const Field& field_;
  std::vector<StraightLinesFrom> lines_;
};

}  // namespace

bool raise_to_straight_lines(const Mesh& mesh, std::span<const std::uint32_t> vertices,
                             Field& field, Poll& poll) {
  const StraightLines lines(mesh, field);
  bool is_any_below = false;
  for (const std::uint32_t v : vertices) {
    if (poll.cancelled()) break;
    is_any_below = lines.raise(v) || is_any_below;
  }
  return is_any_below;
}

bool raise_to_straight_lines(const Mesh& mesh, const SurfacePoint& source,
                             std::span<const std::uint32_t> vertices, std::span<double> distance,
                             Poll& poll) {
  const StraightLinesFrom lines(mesh, source);
  bool is_any_below = false;
  for (const std::uint32_t v : vertices) {
    if (poll.cancelled()) break;
    is_any_below = lines.raise(mesh.positions()[v], distance[v]) || is_any_below;
  }
  return is_any_below;
}

bool raise_to_straight_lines(const Mesh& mesh, Field& field, Poll& poll) {
  const StraightLines lines(mesh, field);
  constexpr std::size_t kAtOnce = 4096;
  std::vector<std::uint8_t> is_any_below(count_ranges(mesh.vertex_count(), poll));
  run_in_ranges(mesh.vertex_count(), poll,
                [&](std::size_t range, std::size_t begin, std::size_t end, Poll& asked) {
                  for (std::size_t v = begin; v < end && !asked.ask(); v += kAtOnce) {
                    if (lines.raise_all(static_cast<std::uint32_t>(v),
                                        static_cast<std::uint32_t>(std::min(end, v + kAtOnce)))) {
                      is_any_below[range] = 1;
                    }
                  }
                });
  return std::any_of(is_any_below.begin(), is_any_below.end(), [](auto any) { return any != 0; });
}

Result<Field> not_below_straight_lines(const Mesh& mesh, Result<Field> field,
                                       const FieldLimits& limits, const Cancel& cancel) {
  if (!field) return field;
  Poll poll(cancel);
  if (limits.targets.empty()) {
    raise_to_straight_lines(mesh, *field, poll);
  } else {
    raise_to_straight_lines(mesh, limits.targets, *field, poll);
  }
  if (poll.stopped()) return fail_stopped(cancel);
  if (limits.max < kUnreached) field->forget_beyond(limits.max);
  field->count_reached();
  return field;
}

}  // namespace geodesic
