#include "core/solve/curve_lines.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/solve/pair_search.h"

namespace geodesic {
namespace {

std::vector<SurfacePoint> by_face(const Adjacency& adjacency, const SurfacePoint& point) {
  std::vector<SurfacePoint> places = in_all_faces(adjacency, point);
  std::stable_sort(places.begin(), places.end(),
                   [](const SurfacePoint& a, const SurfacePoint& b) { return a.face < b.face; });
  return places;
}

// A line within a face that has both points: in `wanted`, or else the one of the least number.
std::optional<LineSegment> within_face(const Adjacency& adjacency, const SurfacePoint& from,
                                       const SurfacePoint& to, std::uint32_t wanted) {
  const std::vector<SurfacePoint> starts = by_face(adjacency, from);
  const std::vector<SurfacePoint> ends = by_face(adjacency, to);
  std::optional<LineSegment> found;
  auto end = ends.begin();
  for (const SurfacePoint& start : starts) {
    while (end != ends.end() && end->face < start.face) ++end;
    if (end == ends.end()) break;
    if (end->face != start.face || (found && start.face != wanted)) continue;
    found = LineSegment{start.face, start.bary, end->bary, 0};
  }
  return found;
}

// The weights of the place of a face that is closest to a position in it or on a side of it.
std::array<double, 3> weights_in(const Adjacency& adjacency, std::uint32_t f, Vec3 position) {
  const Triangle& t = adjacency.mesh().faces()[f];
  const auto positions = adjacency.mesh().positions();
  std::array<double, 3> best{1, 0, 0};
  double least = kUnreached;
  const auto offer = [&](const std::array<double, 3>& bary) {
    const double away = distance(position_of(adjacency.mesh(), {f, bary, kNone}), position);
    if (!(away < least)) return;
    least = away;
    best = bary;
  };
  const Vec3 one = positions[t[1]] - positions[t[0]];
  const Vec3 two = positions[t[2]] - positions[t[0]];
  const Vec3 here = position - positions[t[0]];
  const Vec3 normal = cross(one, two);
  const double square = dot(normal, normal);
  if (square > 0) {
    const double b = dot(cross(here, two), normal) / square;
    const double c = dot(cross(one, here), normal) / square;
    if (b >= 0 && c >= 0 && b + c <= 1) offer({1 - b - c, b, c});
  }
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t n = next_corner(c);
    const double part = foot_on_segment(position, positions[t[c]], positions[t[n]]);
    std::array<double, 3> bary{};
    bary[c] = 1 - part;
    bary[n] = part;
    offer(bary);
  }
  return snapped_point(adjacency, f, best).bary;
}

class CurveWalker {
 public:
  CurveWalker(const Adjacency& adjacency, std::uint32_t item, std::size_t most, SourceLines& lines,
              std::vector<Source>& sources, const Cancel& cancel)
      : adjacency_(adjacency),
        item_(item),
        most_(most),
        lines_(lines),
        sources_(sources),
        cancel_(cancel) {}

  void begin(const SurfacePoint& point) { add_source(point); }

  Result<void> go(const SurfacePoint& from, const SurfacePoint& to, std::uint32_t face) {
    if (is_same_place(from, to)) return {};
    std::optional<LineSegment> segment = within_face(adjacency_, from, to, face);
    if (!segment) {
      // A path that passed faces of no width tells its next point in the face beyond them.
      segment = LineSegment{
          face, from.face == face ? from.bary : weights_in(adjacency_, face, position_in(from)),
          weights_in(adjacency_, face, position_in(to)), 0};
    }
    if (lines_.segments.size() >= most_) {
      return fail_limit(ErrorCode::too_large, "the curves cross too many faces", most_,
                        lines_.segments.size() + 1);
    }
    if (!cancel_.may_take(2 * (sizeof(LineSegment) + sizeof(Source)))) return fail_stopped(cancel_);
    segment->item = item_;
    lines_.segments.push_back(*segment);
    length_ += distance(position_in(from), position_in(to));
    add_source(to);
    return {};
  }

  [[nodiscard]] double length() const { return length_; }

 private:
  [[nodiscard]] Vec3 position_in(const SurfacePoint& point) const {
    return position_of(adjacency_.mesh(), point);
  }
  void add_source(const SurfacePoint& point) {
    sources_.push_back({point, 0});
    lines_.item_of_source.push_back(item_);
  }

  const Adjacency& adjacency_;
  std::uint32_t item_;
  std::size_t most_;
  SourceLines& lines_;
  std::vector<Source>& sources_;
  const Cancel& cancel_;
  double length_ = 0;
};

}  // namespace

Result<double> add_curve(const Adjacency& adjacency, std::span<const SurfacePoint> points,
                         bool is_closed, std::uint32_t item, std::size_t most, SourceLines& lines,
                         std::vector<Source>& sources, SolveScratch& scratch,
                         const Cancel& cancel) {
  CurveWalker walker(adjacency, item, most, lines, sources, cancel);
  walker.begin(points.front());
  const std::size_t legs = is_closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < legs; ++i) {
    if (cancel.requested()) return fail_stopped(cancel);
    const SurfacePoint& from = points[i];
    const SurfacePoint& to = points[(i + 1) % points.size()];
    if (is_same_place(from, to)) continue;
    if (within_face(adjacency, from, to, kNone)) {
      if (auto gone = walker.go(from, to, kNone); !gone) return fail(std::move(gone.error()));
      continue;
    }
    const auto pair =
        pair_search(Method::exact, {}, adjacency, {from, 0}, to, PairPath::traced, scratch, cancel);
    if (!pair) return fail(pair.error());
    if (!pair->path) {
      Error error{ErrorCode::no_loop,
                  "no way leads from this point of the curve to the next one",
                  {},
                  {},
                  {}};
      error.actual = i;
      return tl::unexpected(std::move(error));
    }
    const std::vector<PathPoint>& path = pair->path->points;
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
      // What was asked for, to the last bit.
      const SurfacePoint& start = k == 0 ? from : path[k].point;
      const SurfacePoint& end = k + 2 == path.size() ? to : path[k + 1].point;
      if (auto gone = walker.go(start, end, path[k].point.face); !gone) {
        return fail(std::move(gone.error()));
      }
    }
  }
  return walker.length();
}

}  // namespace geodesic
