#include "core/field/straight_floor.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/tolerances.h"
#include "core/base/vec3.h"
#include "core/surface/point.h"

namespace geodesic {
namespace {

class StraightLines {
 public:
  StraightLines(const Mesh& mesh, Field& field)
      : positions_(mesh.positions()), distance_(field.distance.doubles()), field_(field) {
    for (const Source& source : field.sources) {
      sources_.push_back(from(mesh, source));
    }
  }

  void raise(std::uint32_t v) {
    const std::uint32_t number = field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
    if (number >= sources_.size()) return;  // not reached
    const From& source = sources_[number];
    const Vec3 line = (positions_[v] - source.corner) - source.beyond;
    const double over_surface = distance_[v] - source.offset;
    if (!(over_surface * over_surface < dot(line, line))) return;
    const double straight = norm(line);
    if (over_surface < (1 - tolerance::kSamePath) * straight) is_any_below_ = true;
    distance_[v] = source.offset + straight;
  }
  void raise_all(std::uint32_t begin, std::uint32_t end) {
    if (sources_.size() != 1 || sources_[0].offset != 0) {
      for (std::uint32_t v = begin; v < end; ++v) raise(v);
      return;
    }
    // The usual case: one source without an offset. Hardly any distance has to be raised.
    const From& source = sources_[0];
    for (std::uint32_t v = begin; v < end; ++v) {
      const Vec3 line = (positions_[v] - source.corner) - source.beyond;
      if (distance_[v] * distance_[v] < dot(line, line)) [[unlikely]]
        raise(v);
    }
  }
  [[nodiscard]] bool is_any_below() const { return is_any_below_; }

 private:
  // The place of a source, relative to a corner of its face. The farther the mesh is from the
  // origin, the more coarsely the position itself would be rounded.
  struct From {
    Vec3 corner;
    Vec3 beyond;  // from there to the source
    double offset;
  };
  static From from(const Mesh& mesh, const Source& source) {
    const SurfacePoint& point = source.point;
    const auto positions = mesh.positions();
    if (point.at_vertex()) return {positions[point.vertex], {}, source.offset};
    const Triangle& t = mesh.faces()[point.face];
    const Vec3 corner = positions[t[0]];
    return {corner,
            point.bary[1] * (positions[t[1]] - corner) + point.bary[2] * (positions[t[2]] - corner),
            source.offset};
  }
  std::span<const Vec3> positions_;
  std::span<double> distance_;
  const Field& field_;
  std::vector<From> sources_;
  bool is_any_below_ = false;
};

}  // namespace

bool raise_to_straight_lines(const Mesh& mesh, std::span<const std::uint32_t> vertices,
                             Field& field, Poll& poll) {
  StraightLines lines(mesh, field);
  for (const std::uint32_t v : vertices) {
    if (poll.cancelled()) break;
    lines.raise(v);
  }
  return lines.is_any_below();
}

bool raise_to_straight_lines(const Mesh& mesh, Field& field, Poll& poll) {
  StraightLines lines(mesh, field);
  constexpr std::uint32_t kAtOnce = 4096;
  for (std::uint32_t v = 0; v < mesh.vertex_count() && !poll.ask(); v += kAtOnce) {
    lines.raise_all(v, std::min(mesh.vertex_count(), v + kAtOnce));
  }
  return lines.is_any_below();
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
