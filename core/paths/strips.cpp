#include "core/paths/strips.h"

#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <utility>

#include "core/base/edge_key.h"
#include "core/base/polled_fill.h"
#include "core/paths/faces_by_level.h"
#include "core/paths/isolines.h"

namespace geodesic {
namespace {

// Strip i is between levels i and i + 1.
LevelRange strips_of(const FaceRecord& face, const VertexDistances& distance,
                     std::span<const double> levels) {
  const double a = distance[face.vertex[0]];
  const double b = distance[face.vertex[1]];
  const double c = distance[face.vertex[2]];
  const double least = std::min({a, b, c});
  const double greatest = std::max({a, b, c});
  if (greatest == kUnreached || levels.size() < 2) return {};
  if (greatest < levels.front() || least > levels.back()) return {};
  const auto place = [&](auto it) { return static_cast<std::size_t>(it - levels.begin()); };
  const auto above = std::upper_bound(levels.begin(), levels.end(), least);
  const auto reaching = std::lower_bound(levels.begin(), levels.end(), greatest);
  const std::size_t strips = levels.size() - 1;
  std::size_t first = above == levels.begin() ? 0 : place(above) - 1;
  std::size_t last = std::min(place(reaching), strips);
  if (least == greatest) {
    first = first > 0 && levels[first] == least ? first - 1 : first;
    last = first + 1;
  }
  return first < last ? LevelRange{first, std::min(last, strips)} : LevelRange{};
}

Result<FacesByLevel> faces_of_strips(const Adjacency& adjacency, const Field& field,
                                     std::span<const double> levels, Poll& poll) {
  auto found = list_by_level(
      adjacency, levels.size() - 1,
      [&](const FaceRecord& face) { return strips_of(face, field.distance, levels); },
      [](std::uint64_t) -> Result<void> { return {}; },
      [&](std::size_t entries) { return poll.cancelled_after(1 + entries); }, poll);
  if (poll.stopped()) return fail_stopped(poll);
  return found;
}

// A corner of what is cut out of a face: a vertex, or where a level crosses an edge.
struct CutCorner {
  std::uint32_t low;      // the nearer end of the edge, or the vertex
  std::uint32_t high;     // kNone of a vertex
  bool is_begin = false;  // at which of the strip's levels
};

// Makes the strips one by one.
class StripCutter {
 public:
  StripCutter(const Adjacency& adjacency, const Field& field, Poll& poll)
      : adjacency_(adjacency), field_(field), poll_(poll) {
    polled_assign(place_of_vertex_, adjacency.mesh().vertex_count(), kNone, poll);
  }

  // Of no use if the poll says to stop.
  Strip cut(double begin, double end, std::span<const std::uint32_t> faces) {
    Strip strip;
    strip.begin = begin;
    strip.end = end;
    // A face, cut twice, is five corners and three triangles, and its crossings, two that are its
    // own, are known by their edges: each with two pointers in a table.
    constexpr std::uint64_t kCrossing = sizeof(std::pair<std::uint64_t, std::uint32_t>);
    constexpr std::uint64_t kBytes =
        3 * sizeof(strip.faces[0]) + 5 * sizeof(Vec3) + 2 * (kCrossing + 2 * sizeof(void*));
    if (!poll_.may_take(faces.size() * kBytes)) return strip;
    for (const std::uint32_t f : faces) {
      if (poll_.cancelled()) return strip;
      add(strip, f);
    }
    for (const std::uint32_t v : used_) {
      if (poll_.cancelled()) return strip;
      place_of_vertex_[v] = kNone;
    }
    used_.clear();
    places_at_begin_.clear();
    places_at_end_.clear();
    return strip;
  }

 private:
  void add(Strip& strip, std::uint32_t f) {
    const auto& vertex = adjacency_.face(f).vertex;
    std::array<CutCorner, 7> corners;  // of three sides, at most two cuts each, and what is within
    std::size_t count = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t here = vertex[c];
      const std::uint32_t ahead = vertex[(c + 1) % 3];
      const double d = field_.distance[here];
      const double e = field_.distance[ahead];
      if (strip.begin <= d && d <= strip.end) corners[count++] = {here, kNone};
      const bool by_begin = std::min(d, e) < strip.begin && strip.begin < std::max(d, e);
      const bool by_end = std::min(d, e) < strip.end && strip.end < std::max(d, e);
      const auto [low, high] = d < e ? std::pair(here, ahead) : std::pair(ahead, here);
      if (d < e && by_begin) corners[count++] = {low, high, true};
      if (by_end) corners[count++] = {low, high, false};
      if (d > e && by_begin) corners[count++] = {low, high, true};
    }
    if (count < 3) return;
    std::array<std::uint32_t, 7> places{};
    for (std::size_t i = 0; i < count; ++i) places[i] = place_of(strip, corners[i]);
    for (std::size_t i = 2; i < count; ++i) {
      const std::array<std::uint32_t, 3> face{places[0], places[i - 1], places[i]};
      // Two crossings may be rounded to one point; triangles as thin stay.
      strip.area += area_of(strip, face);
      strip.faces.push_back(face);
    }
  }

  static double area_of(const Strip& strip, const std::array<std::uint32_t, 3>& face) {
    const Vec3 a = strip.positions[face[0]];
    return norm(cross(strip.positions[face[1]] - a, strip.positions[face[2]] - a)) / 2;
  }

  std::uint32_t place_of(Strip& strip, const CutCorner& corner) {
    const auto next = static_cast<std::uint32_t>(strip.positions.size());
    if (corner.high == kNone) {
      std::uint32_t& place = place_of_vertex_[corner.low];
      if (place == kNone) {
        place = next;
        used_.push_back(corner.low);
        strip.positions.push_back(adjacency_.mesh().positions()[corner.low]);
      }
      return place;
    }
    const std::uint64_t edge = edge_key(corner.low, corner.high);
    auto& places = corner.is_begin ? places_at_begin_ : places_at_end_;
    const auto [it, is_new] = places.emplace(edge, next);
    if (is_new) {
      const double level = corner.is_begin ? strip.begin : strip.end;
      strip.positions.push_back(
          crossing_of(adjacency_.mesh(), field_, level, corner.low, corner.high));
    }
    return it->second;
  }

  const Adjacency& adjacency_;
  const Field& field_;
  Poll& poll_;
  std::vector<std::uint32_t> place_of_vertex_;  // in the strip; kNone of those that it has not
  std::vector<std::uint32_t> used_;             // the vertices that it has
  std::unordered_map<std::uint64_t, std::uint32_t> places_at_begin_;  // by edge
  std::unordered_map<std::uint64_t, std::uint32_t> places_at_end_;
};

}  // namespace

Result<std::vector<Strip>> cut_strips(const Adjacency& adjacency, const Field& field,
                                      std::span<const double> levels, const Cancel& cancel) {
  std::vector<Strip> strips;
  if (levels.size() < 2) return strips;
  Poll poll(cancel);
  const auto faces = faces_of_strips(adjacency, field, levels, poll);
  if (!faces) return fail(faces.error());
  StripCutter cutter(adjacency, field, poll);
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    if (poll.cancelled(faces->begin[i], faces->face.size())) return fail_stopped(poll);
    strips.push_back(cutter.cut(levels[i], levels[i + 1], faces->of(i)));
    if (poll.stopped()) return fail_stopped(poll);
  }
  return strips;
}

}  // namespace geodesic
