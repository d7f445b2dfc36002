#include "core/paths/discs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/base/vec3.h"
#include "core/field/nearest_copies.h"
#include "core/paths/isolines.h"

namespace geodesic {
namespace {

// Area, and the integral of the distance over it.
struct Amount {
  double area = 0;
  double integral = 0;

  Amount& operator+=(const Amount& other) {
    area += other.area;
    integral += other.integral;
    return *this;
  }
};

// A face with its corners' distances, ascending.
struct LinearFace {
  std::array<double, 3> corner;
  double area;

  [[nodiscard]] Amount whole() const {
    return {area, area * ((corner[0] + corner[1] + corner[2]) / 3)};
  }
  // What is no farther than a radius between the nearest corner and the farthest.
  [[nodiscard]] Amount within(double radius) const {
    const auto [a, b, c] = corner;
    if (radius <= b) {
      const double part = (radius - a) / (b - a) * ((radius - a) / (c - a));
      return {area * part, area * part * ((a + 2 * radius) / 3)};
    }
    // Two triangles, with the corners' distances a, b, radius and a, radius, radius. Less the rest
    // would be near nothing less the same, where the disc ends close to the nearer two corners.
    const double first = (radius - b) / (c - b);
    const double second = (c - radius) / (c - b) * ((radius - a) / (c - a));
    return {area * (first + second),
            area * (first * ((a + b + radius) / 3) + second * ((a + 2 * radius) / 3))};
  }
};

// Of each edge one halfedge is: along a ring they ascend by the vertex opposite and then by their
// own numbers, from the first to the last.
bool is_last_of_edge(const Adjacency& adjacency, Halfedge h) {
  const Halfedge next = adjacency.ring(h);
  const auto opposite = [&](Halfedge side) {
    return adjacency.face(face_of(side)).vertex[previous_corner(corner_of(side))];
  };
  return std::pair(opposite(next), next) <= std::pair(opposite(h), h);
}

// Goes over the faces once and adds up, per radius, all but what needs the lines.
class DiscSums {
 public:
  DiscSums(const Adjacency& adjacency, const Field& field, std::span<const double> radii)
      : adjacency_(adjacency),
        field_(field),
        radii_(radii),
        within_(radii.size()),
        from_(radii.size() + 1) {}

  // Whether it came to the end.
  [[nodiscard]] bool add_all(Poll& poll) {
    const Mesh& mesh = adjacency_.mesh();
    const std::uint64_t total = mesh.face_count() + mesh.source_vertex_count();
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
      if (poll.cancelled(f, total)) return false;
      add_face(f, poll);
    }
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      if (poll.cancelled()) return false;
      if (adjacency_.corners(v).empty()) continue;
      from_[first_with(field_.distance[v])].euler += 1;
      farthest_ = std::max(farthest_, field_.distance[v]);
    }
    const auto nearer = nearer_copies(
        mesh, [&](std::uint32_t v) { return field_.distance[v]; }, poll);
    std::uint64_t seen = mesh.face_count();
    for (const std::uint32_t v : mesh.vertex_of_source()) {
      if (poll.cancelled(seen++, total)) return false;
      if (v == kNone) continue;
      from_[first_with(field_.distance[nearest_copy(nearer, v)])].vertices += 1;
    }
    return !poll.stopped();
  }

  // Without perimeters and lines.
  [[nodiscard]] std::vector<Disc> discs() const {
    std::vector<Disc> discs(radii_.size());
    Step sum;
    for (std::size_t i = 0; i < radii_.size(); ++i) {
      const Step& step = from_[i];
      sum.amount += step.amount;
      sum.boundary += step.boundary;
      sum.vertices += step.vertices;
      sum.euler += step.euler;
      Amount amount = sum.amount;
      amount += within_[i].amount;
      discs[i].radius = radii_[i];
      discs[i].area = amount.area;
      discs[i].mean = amount.area > 0 ? amount.integral / amount.area : 0;
      discs[i].boundary = std::max(0.0, sum.boundary + within_[i].boundary);
      discs[i].vertices = sum.vertices;
      discs[i].euler = sum.euler;
      discs[i].is_whole = radii_[i] >= farthest_;
    }
    return discs;
  }

  // How many faces the isoline of each radius crosses.
  [[nodiscard]] std::vector<std::uint64_t> crossings() const {
    std::vector<std::uint64_t> counts;
    counts.reserve(within_.size());
    for (const Part& part : within_) counts.push_back(part.crossings);
    return counts;
  }

 private:
  struct Part {  // of faces and edges that a radius goes through
    Amount amount;
    double boundary = 0;
    std::uint64_t crossings = 0;
  };
  struct Step {  // what this radius and all greater ones have besides the lesser ones
    Amount amount;
    double boundary = 0;
    std::uint64_t vertices = 0;
    std::int64_t euler = 0;
  };

  // The first radius that is at least so great; one more than there are for none.
  [[nodiscard]] std::size_t first_with(double distance) const {
    return static_cast<std::size_t>(std::lower_bound(radii_.begin(), radii_.end(), distance) -
                                    radii_.begin());
  }
  [[nodiscard]] std::size_t first_above(double distance) const {
    return static_cast<std::size_t>(std::upper_bound(radii_.begin(), radii_.end(), distance) -
                                    radii_.begin());
  }

  void add_face(std::uint32_t f, Poll& poll) {
    const FaceRecord& face = adjacency_.face(f);
    std::array<double, 3> d{};
    for (std::size_t c = 0; c < 3; ++c) d[c] = field_.distance[face.vertex[c]];
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (!is_last_of_edge(adjacency_, halfedge(f, c))) continue;
      from_[first_with(std::max(d[c], d[next_corner(c)]))].euler -= 1;
    }
    if (std::max({d[0], d[1], d[2]}) == kUnreached) return;
    for (std::uint32_t c = 0; c < 3; ++c) add_boundary(f, c, d, poll);
    LinearFace linear{d, face.area2 / 2};
    std::sort(linear.corner.begin(), linear.corner.end());
    const std::size_t end = first_with(linear.corner[2]);
    for (std::size_t i = first_above(linear.corner[0]); i < end; ++i) {
      if (poll.cancelled()) return;
      within_[i].amount += linear.within(radii_[i]);
      ++within_[i].crossings;
    }
    from_[end].amount += linear.whole();
    from_[end].euler += 1;
    // The line at the farthest corner, or along the farther two.
    const bool is_level = end < radii_.size() && radii_[end] == linear.corner[2];
    if (is_level && linear.corner[0] < linear.corner[2]) ++within_[end].crossings;
  }

  void add_boundary(std::uint32_t f, std::uint32_t c, const std::array<double, 3>& d, Poll& poll) {
    if (adjacency_.ring(halfedge(f, c)) != halfedge(f, c)) return;
    const auto [a, b] = std::minmax(d[c], d[next_corner(c)]);
    const FaceRecord& face = adjacency_.face(f);
    const auto positions = adjacency_.mesh().positions();
    const double length =
        distance(positions[face.vertex[c]], positions[face.vertex[next_corner(c)]]);
    const std::size_t end = first_with(b);
    for (std::size_t i = first_above(a); i < end; ++i) {
      if (poll.cancelled()) return;
      within_[i].boundary += length * ((radii_[i] - a) / (b - a));
    }
    from_[end].boundary += length;
    const bool is_isoline = a == b && d[previous_corner(c)] < a;
    if (is_isoline && end < radii_.size() && radii_[end] == a) within_[end].boundary -= length;
  }

  const Adjacency& adjacency_;
  const Field& field_;
  std::span<const double> radii_;
  std::vector<Part> within_;
  std::vector<Step> from_;
  double farthest_ = 0;
};

// Lines of several radii at once are as long as those of one may be.
constexpr std::uint64_t kCrossingsAtOnce = 1'000'000;

Result<void> add_lines(const Adjacency& adjacency, const Field& field,
                       std::span<const double> radii, std::span<const std::uint64_t> crossings,
                       std::vector<Disc>& discs, const Cancel& cancel) {
  std::size_t begin = 0;
  while (begin < radii.size()) {
    std::size_t end = begin + 1;
    std::uint64_t sum = crossings[begin];
    while (end < radii.size() && sum + crossings[end] <= kCrossingsAtOnce) sum += crossings[end++];
    const auto size = static_cast<double>(radii.size());
    const Cancel part =
        cancel.part(static_cast<double>(begin) / size, static_cast<double>(end) / size);
    std::size_t i = begin;
    auto lines = each_isoline(
        adjacency, field, radii.subspan(begin, end - begin),
        std::numeric_limits<std::uint64_t>::max(),
        [&](Isoline&& line) {
          while (radii[i] < line.level) ++i;
          discs[i].perimeter += line.length;
          ++discs[i].lines;
        },
        part);
    if (!lines) return lines;
    begin = end;
  }
  return {};
}

}  // namespace

Result<Discs> measure_discs(const Adjacency& adjacency, const Field& field,
                            std::span<const double> radii, const Cancel& cancel) {
  constexpr double kSums = 0.3;  // the part of the time that is not for the lines
  const Cancel summing = cancel.part(0, kSums);
  Poll poll(summing);
  DiscSums sums(adjacency, field, radii);
  if (!sums.add_all(poll)) return fail_stopped(poll);
  Discs found{sums.discs(), 0};
  const std::vector<std::uint64_t> crossings = sums.crossings();
  for (const std::uint64_t count : crossings) found.crossings += count;
  auto lines = add_lines(adjacency, field, radii, crossings, found.discs, cancel.part(kSums, 1));
  if (!lines) return fail(std::move(lines.error()));
  return found;
}

}  // namespace geodesic
