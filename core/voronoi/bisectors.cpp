#include "core/voronoi/bisectors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <tuple>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"
#include "core/voronoi/face_cells.h"

namespace geodesic {
namespace {

using Sites2 = std::array<std::uint32_t, 2>;

// The part of a bisector in one face.
struct BisectorSegment {
  Sites2 sites;
  std::array<Vec3, 2> ends;
  // What goes on at an end: twice the number of a segment, and its own end there.
  std::array<std::uint32_t, 2> beyond{kNone, kNone};
};

// An end of a segment on an edge. No two bisectors of the same sites cross an edge. What runs along
// an edge ends at a vertex.
struct EdgeEnd {
  std::array<std::uint32_t, 2> edge;  // its vertices, ascending; or one vertex twice
  Sites2 sites;
  std::uint32_t end;  // twice the number of the segment, and which of its ends

  [[nodiscard]] bool is_at(const EdgeEnd& other) const {
    return edge == other.edge && sites == other.sites;
  }
  friend bool operator<(const EdgeEnd& a, const EdgeEnd& b) {
    return std::tie(a.edge, a.sites, a.end) < std::tie(b.edge, b.sites, b.end);
  }
};

// The distance of a point of a face from a site that the face is laid out with (Stewart's theorem).
double distance_in_face(const FaceRecord& face, const std::array<double, 3>& square,
                        const std::array<double, 3>& bary) {
  double sum = 0;
  for (std::uint32_t c = 0; c < 3; ++c) {
    sum += bary[c] * square[c] - bary[c] * bary[next_corner(c)] * face.length2(c);
  }
  return std::sqrt(std::max(sum, 0.0));
}

class BisectorTracer {
 public:
  BisectorTracer(const Adjacency& adjacency, const NearSites& near, std::uint64_t max_segments,
                 std::span<VoronoiCell> cells, Poll& poll)
      : adjacency_(adjacency),
        near_(near),
        max_segments_(max_segments),
        cells_(cells),
        poll_(poll),
        face_cells_(adjacency, near) {}

  Result<Bisectors> trace() {
    const std::uint32_t faces = adjacency_.mesh().face_count();
    for (std::uint32_t f = 0; f < faces; ++f) {
      if (poll_.cancelled_after(1, f, faces)) return fail_stopped(poll_);
      for (const CellPart& part : face_cells_.parts_of(f, poll_)) add(f, part);
      if (near_.owner(f) != kNone) add_borders(f);
      if (poll_.stopped()) return fail_stopped(poll_);
    }
    if (segments_.size() > max_segments_) {
      return fail_limit(ErrorCode::too_large, "the bisectors have too many segments", max_segments_,
                        count_);
    }
    found_.segments = count_;
    join();
    if (poll_.stopped()) return fail_stopped(poll_);
    follow();
    if (poll_.stopped()) return fail_stopped(poll_);
    return std::move(found_);
  }

 private:
  [[nodiscard]] Vec3 at(std::uint32_t f, const std::array<double, 3>& weights) const {
    return position_in_face(adjacency_, f, weights);
  }

  void add(std::uint32_t f, const CellPart& part) {
    const std::size_t count = part.sides.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t next = (i + 1) % count;
      const CellSide side = part.sides[i];
      const Vec3 begin = at(f, part.corners[i]);
      const Vec3 end = at(f, part.corners[next]);
      const double length = distance(begin, end);
      if (side.is_of_face()) {
        const Halfedge h = halfedge(f, side.corner());
        if (adjacency_.ring(h) == h) cells_[part.site].boundary += length;
        continue;
      }
      // Both cells at it have it, once from each side.
      if (side.site() < part.site) continue;
      cells_[part.site].perimeter += length;
      cells_[side.site()].perimeter += length;
      add_segment(f, {part.site, side.site()}, {begin, end},
                  {part.sides[(i + count - 1) % count], part.sides[next]});
      if (count_ <= max_segments_) add_vertex(f, part, i);
    }
  }

  // Along the edges of a face that a site has as a whole, where the cell beyond is another one.
  void add_borders(std::uint32_t f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const Halfedge beyond = adjacency_.ring(h);
      if (beyond == h || adjacency_.ring(beyond) != h) continue;
      const std::uint32_t own = near_.owner(f);
      const std::uint32_t other = border_site(adjacency_, near_, beyond);
      // Of two faces that sites have as a whole, the first is asked.
      const bool is_asked = near_.owner(face_of(beyond)) == kNone || f < face_of(beyond);
      if (other == kNone || other == own || !is_asked) continue;
      const std::array<std::uint32_t, 2> vertices{adjacency_.tail(h), adjacency_.head(h)};
      const auto positions = adjacency_.mesh().positions();
      const std::array<Vec3, 2> ends{positions[vertices[0]], positions[vertices[1]]};
      const double length = distance(ends[0], ends[1]);
      cells_[own].perimeter += length;
      cells_[other].perimeter += length;
      const auto [low, high] = std::minmax(own, other);
      const auto number = add_segment({low, high}, ends);
      if (!number) return;
      for (std::uint32_t end = 0; end < 2; ++end) {
        ends_.push_back({{vertices[end], vertices[end]}, {low, high}, 2 * *number + end});
      }
    }
  }

  // Its number, if there is room for it.
  std::optional<std::uint32_t> add_segment(Sites2 sites, std::array<Vec3, 2> ends) {
    // They are counted on, so that the error can say how many there are.
    if (++count_ > max_segments_ + 1) return std::nullopt;
    // Itself and its ends; a line of its own, whose points may have grown by doubling; and the
    // points where three cells meet, of which there are fewer.
    constexpr std::uint64_t kBytes = sizeof(BisectorSegment) + 2 * sizeof(EdgeEnd) +
                                     sizeof(Bisector) + 3 * sizeof(Vec3) + sizeof(VoronoiVertex);
    if (segments_.size() == segments_.capacity()) {
      const std::size_t more = std::max<std::size_t>(segments_.capacity(), 256);
      if (!poll_.may_take(2 * more * kBytes)) return std::nullopt;
      segments_.reserve(segments_.size() + more);
      ends_.reserve(2 * segments_.capacity());
    }
    segments_.push_back({sites, ends});
    return static_cast<std::uint32_t>(segments_.size() - 1);
  }

  void add_segment(std::uint32_t f, Sites2 sites, std::array<Vec3, 2> ends,
                   const std::array<CellSide, 2>& beside) {
    const auto number = add_segment(sites, ends);
    if (!number) return;
    for (std::uint32_t end = 0; end < 2; ++end) {
      if (!beside[end].is_of_face()) continue;
      const auto& vertex = adjacency_.face(f).vertex;
      const std::uint32_t c = beside[end].corner();
      const auto [low, high] = std::minmax(vertex[c], vertex[next_corner(c)]);
      ends_.push_back({{low, high}, sites, 2 * *number + end});
    }
  }

  // The point after side i of the part of the lowest of three sites.
  void add_vertex(std::uint32_t f, const CellPart& part, std::size_t i) {
    const std::size_t next = (i + 1) % part.sides.size();
    const CellSide after = part.sides[next];
    if (after.is_of_face() || after.site() < part.site) return;
    VoronoiVertex vertex;
    const auto [low, high] = std::minmax({part.sides[i].site(), after.site()});
    vertex.sites = {part.site, low, high};
    if (face_cells_.turn(vertex.sites) < 0) std::swap(vertex.sites[1], vertex.sites[2]);
    vertex.position = at(f, part.corners[next]);
    vertex.point = point_on_face(adjacency_, f, part.corners[next]);
    // Of a point, if any of the three is one: beside lines, distances are linear.
    std::uint32_t site = part.site;
    for (const std::uint32_t other : {low, high}) {
      if (near_.is_line(site)) site = other;
    }
    if (near_.is_line(site)) site = part.site;
    const FaceRecord& face = adjacency_.face(f);
    std::array<double, 3> square{};
    double linear = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      square[c] = near_.square(face.vertex[c], site) * near_.unit() * near_.unit();
      linear += part.corners[next][c] * std::sqrt(square[c]);
    }
    vertex.distance =
        near_.is_line(site) ? linear : distance_in_face(face, square, part.corners[next]);
    found_.vertices.push_back(vertex);
  }

  // Finds for each end on an edge the segment beyond.
  void join() {
    std::vector<EdgeEnd> spare;
    polled_sort(ends_, 0, ends_.size(), std::less<>(), spare, poll_);
    for (std::size_t begin = 0; begin < ends_.size();) {
      std::size_t end = begin;
      while (end < ends_.size() && ends_[end].is_at(ends_[begin])) {
        if (poll_.cancelled()) return;
        ++end;
      }
      if (end - begin == 2) {
        const std::uint32_t one = ends_[begin].end;
        const std::uint32_t other = ends_[begin + 1].end;
        segments_[one / 2].beyond[one % 2] = other;
        segments_[other / 2].beyond[other % 2] = one;
      }
      begin = end;
    }
  }

  void follow() {
    std::vector<bool> is_done(segments_.size());
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      if (poll_.cancelled()) return;
      if (is_done[s]) continue;
      Bisector line;
      line.sites = segments_[s].sites;
      is_done[s] = true;
      std::vector<Vec3> ahead{segments_[s].ends[1]};
      line.closed = walk(s, 1, ahead, is_done);
      std::vector<Vec3> points;
      if (!line.closed) {
        std::vector<Vec3> behind{segments_[s].ends[0]};
        walk(s, 0, behind, is_done);
        std::reverse(behind.begin(), behind.end());
        points = std::move(behind);
      }
      points.insert(points.end(), ahead.begin(), ahead.end());
      points.erase(std::unique(points.begin(), points.end()), points.end());
      while (line.closed && points.size() > 1 && points.back() == points.front()) points.pop_back();
      for (std::size_t i = 1; i < points.size(); ++i) {
        line.length += distance(points[i - 1], points[i]);
      }
      if (line.closed) line.length += distance(points.back(), points.front());
      // Three cells may meet so near an edge that rounding leaves a point.
      if (points.size() < 2) continue;
      line.points = std::move(points);
      found_.lines.push_back(std::move(line));
    }
    std::stable_sort(found_.lines.begin(), found_.lines.end(),
                     [](const Bisector& a, const Bisector& b) { return a.sites < b.sites; });
  }

  // Goes on at one end, adding the far ends of what follows. Whether it came round; then the last
  // point that was added is that which it would leave again.
  bool walk(std::uint32_t start, std::uint32_t end, std::vector<Vec3>& points,
            std::vector<bool>& is_done) {
    std::uint32_t next = segments_[start].beyond[end];
    while (next != kNone && !poll_.cancelled()) {
      if (next / 2 == start) return true;
      is_done[next / 2] = true;
      const BisectorSegment& segment = segments_[next / 2];
      const std::uint32_t far = 1 - next % 2;
      points.push_back(segment.ends[far]);
      next = segment.beyond[far];
    }
    return false;
  }

  const Adjacency& adjacency_;
  const NearSites& near_;
  const std::uint64_t max_segments_;
  std::span<VoronoiCell> cells_;
  Poll& poll_;
  FaceCells face_cells_;
  std::vector<BisectorSegment> segments_;
  std::vector<EdgeEnd> ends_;
  std::uint64_t count_ = 0;
  Bisectors found_;
};

}  // namespace

Result<Bisectors> trace_bisectors(const Adjacency& adjacency, const NearSites& near,
                                  std::uint64_t max_segments, std::span<VoronoiCell> cells,
                                  const Cancel& cancel) {
  Poll poll(cancel);
  return BisectorTracer(adjacency, near, max_segments, cells, poll).trace();
}

}  // namespace geodesic
