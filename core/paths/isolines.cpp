#include "core/paths/isolines.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/paths/faces_by_level.h"

namespace geodesic {
namespace {

LevelRange levels_across(const FaceRecord& face, const VertexDistances& distance,
                         std::span<const double> levels) {
  const double a = distance[face.vertex[0]];
  const double b = distance[face.vertex[1]];
  const double c = distance[face.vertex[2]];
  const double greatest = std::max({a, b, c});
  if (greatest == kUnreached) return {};
  // Some vertex is below the level, and some is on it or above.
  const auto first = std::upper_bound(levels.begin(), levels.end(), std::min({a, b, c}));
  const auto last = std::upper_bound(first, levels.end(), greatest);
  return {static_cast<std::size_t>(first - levels.begin()),
          static_cast<std::size_t>(last - levels.begin())};
}

Result<FacesByLevel> crossed_faces(const Adjacency& adjacency, const Field& field,
                                   std::span<const double> levels, std::uint64_t max_segments,
                                   Poll& poll) {
  // Two passes over the faces, and one over what they found.
  const std::uint64_t total = 3 * std::uint64_t{adjacency.faces().size()};
  std::uint64_t seen = 0;
  auto crossed = list_by_level(
      adjacency, levels.size(),
      [&](const FaceRecord& face) { return levels_across(face, field.distance, levels); },
      [&](std::uint64_t segments) -> Result<void> {
        if (segments > max_segments) {
          return fail_limit(ErrorCode::too_large, "the isolines have too many segments",
                            max_segments, segments);
        }
        // A segment has its face, and a point on a line that may have grown by doubling.
        if (!poll.may_take(segments * (sizeof(std::uint32_t) + 2 * sizeof(Vec3)))) {
          return fail_stopped(poll);
        }
        return {};
      },
      [&](std::size_t entries) { return poll.cancelled_after(1 + entries, seen++, total); }, poll);
  if (poll.stopped()) return fail_stopped(poll);
  return crossed;
}

// Follows the lines of one level from face to face.
class LineWalker {
 public:
  LineWalker(const Adjacency& adjacency, const Field& field, Poll& poll)
      : adjacency_(adjacency), field_(field), poll_(poll), passed_(adjacency.faces().size(), 0) {}

  // `round`: differs from level to level, and is not 0.
  void start_level(double level, std::uint32_t round) {
    level_ = level;
    round_ = round;
  }
  [[nodiscard]] bool passed(std::uint32_t face) const { return passed_[face] == round_; }

  // The whole line through a face that the level crosses; of no use if the poll says to stop.
  Isoline line_through(std::uint32_t face) {
    Isoline line;
    line.level = level_;
    const auto [one, other] = crossed_sides(face);
    passed_[face] = round_;
    std::vector<Vec3> ahead{crossing(one)};
    line.closed = walk(one, ahead);
    std::vector<Vec3> behind;
    if (!line.closed) {
      behind.push_back(crossing(other));
      walk(other, behind);
    }
    line.points.reserve(ahead.size() + behind.size());
    for (auto it = behind.rbegin(); it != behind.rend(); ++it) add(line.points, *it);
    for (const Vec3 point : ahead) add(line.points, point);
    if (line.closed) {
      while (line.points.size() > 1 && line.points.back() == line.points.front()) {
        line.points.pop_back();
      }
    }
    for (std::size_t i = 1; i < line.points.size(); ++i) {
      line.length += distance(line.points[i - 1], line.points[i]);
    }
    if (line.closed) line.length += distance(line.points.back(), line.points.front());
    return line;
  }

 private:
  [[nodiscard]] bool above(std::uint32_t vertex) const { return field_.distance[vertex] >= level_; }

  // The two sides between a vertex above and one below.
  [[nodiscard]] std::pair<Halfedge, Halfedge> crossed_sides(std::uint32_t f) const {
    const FaceRecord& face = adjacency_.face(f);
    // The corner that is alone on its side of the level.
    for (std::uint32_t c = 0; c < 3; ++c) {
      const bool here = above(face.vertex[c]);
      if (here != above(face.vertex[next_corner(c)]) &&
          here != above(face.vertex[previous_corner(c)])) {
        return {halfedge(f, c), halfedge(f, previous_corner(c))};
      }
    }
    return {kNone, kNone};  // not a face that the level crosses
  }

  // The same for both directions of an edge, to the last bit.
  [[nodiscard]] Vec3 crossing(Halfedge h) const {
    const FaceRecord& face = adjacency_.face(face_of(h));
    std::uint32_t low = face.vertex[corner_of(h)];
    std::uint32_t high = face.vertex[next_corner(corner_of(h))];
    if (above(low)) std::swap(low, high);
    return crossing_of(adjacency_.mesh(), field_, level_, low, high);
  }

  // Goes on across `side`, adding the crossings after it. Whether it came round to
  // where it started; then all of the line is in `points`.
  //
  // A face that the level crosses has two such sides, and an edge that it goes on over two
  // faces: so it can come back to no face but that where it started.
  bool walk(Halfedge side, std::vector<Vec3>& points) {
    const std::uint32_t start = face_of(side);
    while (!poll_.cancelled()) {
      const Halfedge across = adjacency_.ring(side);
      if (across == side || adjacency_.ring(across) != side) return false;
      const std::uint32_t face = face_of(across);
      if (face == start) return true;
      if (!reached(face)) return false;
      passed_[face] = round_;
      const auto [one, other] = crossed_sides(face);
      side = one == across ? other : one;
      points.push_back(crossing(side));
    }
    return false;
  }

  [[nodiscard]] bool reached(std::uint32_t f) const {
    const auto& vertex = adjacency_.face(f).vertex;
    return std::all_of(vertex.begin(), vertex.end(),
                       [&](std::uint32_t v) { return field_.distance[v] != kUnreached; });
  }

  static void add(std::vector<Vec3>& points, Vec3 point) {
    if (points.empty() || !(points.back() == point)) points.push_back(point);
  }

  const Adjacency& adjacency_;
  const Field& field_;
  Poll& poll_;
  std::vector<std::uint32_t> passed_;  // by face: the last round that did
  double level_ = 0;
  std::uint32_t round_ = 0;
};

}  // namespace

Vec3 crossing_of(const Mesh& mesh, const Field& field, double level, std::uint32_t low,
                 std::uint32_t high) {
  const auto positions = mesh.positions();
  const double rise = field.distance[high] - field.distance[low];
  const double part = (level - field.distance[low]) / rise;
  if (part == 1) return positions[high];
  return positions[low] + part * (positions[high] - positions[low]);
}

Result<void> each_isoline(const Adjacency& adjacency, const Field& field,
                          std::span<const double> levels, std::uint64_t max_segments,
                          const std::function<void(Isoline&&)>& take, const Cancel& cancel) {
  Poll poll(cancel);
  const auto crossed = crossed_faces(adjacency, field, levels, max_segments, poll);
  if (!crossed) return fail(crossed.error());
  LineWalker walker(adjacency, field, poll);
  const std::uint64_t segments = crossed->face.size();
  std::uint64_t seen = 2 * segments;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    walker.start_level(levels[level], static_cast<std::uint32_t>(level + 1));
    for (const std::uint32_t face : crossed->of(level)) {
      if (poll.cancelled(seen++, 3 * segments)) {
        return fail_stopped(poll);
      }
      if (walker.passed(face)) continue;
      Isoline line = walker.line_through(face);
      if (poll.stopped()) return fail_stopped(poll);
      if (line.points.size() > 1) take(std::move(line));
    }
  }
  return {};
}

Result<std::vector<Isoline>> isolines(const Adjacency& adjacency, const Field& field,
                                      std::span<const double> levels, std::uint64_t max_segments,
                                      const Cancel& cancel) {
  std::vector<Isoline> lines;
  auto found = each_isoline(
      adjacency, field, levels, max_segments,
      [&](Isoline&& line) { lines.push_back(std::move(line)); }, cancel);
  if (!found) return fail(std::move(found.error()));
  return lines;
}

}  // namespace geodesic
