#include "core/straighten/shorten_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/base/tolerances.h"
#include "core/straighten/face_strip.h"
#include "core/straighten/funnel.h"
#include "core/straighten/path_chain.h"
#include "core/straighten/vertex_fan.h"

namespace geodesic {
namespace {

// Of a portal's length, what rounding may make of where its ends are.
constexpr double kRoundingOfEnds = 1e-15;

class Shortener {
 public:
  Shortener(const Adjacency& adjacency, const Cancel& cancel)
      : adjacency_(adjacency), poll_(cancel), fans_(adjacency, poll_) {}

  Result<Path> shorten(const Path& path, bool over_vertices) {
    auto chain = read_chain(adjacency_, path, poll_);
    if (!chain && !poll_.stopped()) return path;
    if (chain) pull_straight(*chain);
    // Each round takes some part off the length, or lets a vertex pass that it lets pass once;
    // and all of them together unfold no more than kMostFacesUnfolded.
    while (chain && over_vertices && cross_all_vertices(*chain)) ++counts_.rounds;
    if (poll_.stopped()) return fail_stopped(poll_);
    Path result = write_path(adjacency_, *chain, path);
    if (result.length < path.length * (1 - tolerance::kLeastGain)) return result;
    return path;
  }

  [[nodiscard]] ShortenCounts counts() const {
    ShortenCounts counts = counts_;
    counts.locally_shortest = !over_limit();
    return counts;
  }

 private:
  [[nodiscard]] bool over_limit() const { return counts_.faces_unfolded > kMostFacesUnfolded; }
  [[nodiscard]] bool stopped() const { return cancelled_ || over_limit(); }

  // -- Straight within the strip ------------------------------------------------

  // The strip from path vertex `first` to path vertex `last` of a chain, by `fan(i)` at each
  // path vertex between.
  template <class FanAt>
  static FaceStrip joined(const Chain& chain, std::size_t first, std::size_t last, FanAt fan) {
    FaceStrip strip = chain.segments[first].strip;
    for (std::size_t i = first + 1; i < last; ++i) {
      for (const Portal& portal : fan(i).portals) strip.cross(portal);
      for (const Portal& portal : chain.segments[i].strip.portals) strip.cross(portal);
    }
    return strip;
  }

  enum class Side : std::uint8_t { none, left, right };
  struct PortalCrossing {
    double from_left;  // where, in parts of the portal
    Side through;      // the end that the line runs through
  };

  // Where the straight line in a direction comes over a portal. `here`: where it has come over the
  // one before. `stop`: the last vertex that it runs through, or its start.
  static PortalCrossing cross_portal(const UnfoldedStrip& plane, const UnfoldedPortal& portal,
                                     Vec2 along, Vec2 here, Vec2 stop) {
    const Vec2 side = portal.right - portal.left;
    const double off_left = cross(along, portal.left - plane.start);
    const double off_right = cross(along, portal.right - plane.start);
    const double left = std::max(off_left, 0.0);
    const double right = std::max(-off_right, 0.0);
    const double off = std::max(std::abs(off_left), std::abs(off_right));
    // The direction of a short line is known less well, and the farther off its ends are.
    const double reach =
        std::max(norm(portal.left - plane.start), norm(portal.right - plane.start));
    const double rounding =
        kRoundingOfEnds * norm(side) * (1 + reach / norm(plane.end - plane.start));
    double from_left = 0;
    bool is_left = true;  // whether the left end is the one that the line may run through
    bool is_passed = true;
    if (off > rounding && left + right > 0) {
      from_left = left / (left + right);
      is_left = from_left < 0.5;
    } else {
      // The line runs along the portal, and comes over it where it is on it: at the end that comes
      // first, or, as in faces without width, between its ends.
      const double length2 = dot(side, side);
      const double at = length2 > 0 ? dot(here - portal.left, side) / length2 : 0;
      from_left = std::clamp(at, 0.0, 1.0);
      is_left = at <= 0;
      if (at > 0 && at < 1) {
        is_left = dot(side, along) < 0;  // the end ahead
        is_passed = dot(plane.end - (is_left ? portal.left : portal.right), along) > 0;
      }
    }
    const Vec2 vertex = is_left ? portal.left : portal.right;
    const double arm = std::min(norm(vertex - stop), norm(plane.end - vertex));
    const bool is_through = is_passed && (is_left ? left : right) < tolerance::kThroughVertex * arm;
    return {from_left, !is_through ? Side::none : is_left ? Side::left : Side::right};
  }

  // The straight line from one end of a strip to the other. Where rounding would
  // take it out of the strip it is held back at the edge's end. The vertices that it
  // runs through are left in run_through_.
  PathSegment lay(FaceStrip strip, const SurfacePoint& from, const SurfacePoint& to) {
    unfold(strip, from, to);
    const UnfoldedStrip& plane = segment_plane_;
    PathSegment segment;
    const Vec2 start = plane.start;
    const Vec2 along = unit(plane.end - start);
    run_through_.clear();
    segment.crossings.reserve(strip.portals.size());
    Vec2 here = start;
    Vec2 stop = start;  // or the last vertex that the line runs through
    for (std::size_t i = 0; i < strip.portals.size(); ++i) {
      const UnfoldedPortal& unfolded_portal = plane.unfolded_portals[i];
      const PortalCrossing crossing = cross_portal(plane, unfolded_portal, along, here, stop);
      if (crossing.through != Side::none) {
        run_through_.push_back({i, crossing.through == Side::left});
        stop = crossing.through == Side::left ? unfolded_portal.left : unfolded_portal.right;
      }
      const double from_left = crossing.from_left;
      const Vec2 there =
          unfolded_portal.left + from_left * (unfolded_portal.right - unfolded_portal.left);
      segment.length += norm(there - here);
      here = there;
      const Halfedge in = strip.portals[i].in;
      const bool tail_is_left =
          adjacency_.face(face_of(in)).vertex[corner_of(in)] == unfolded_portal.left_vertex;
      segment.crossings.push_back(tail_is_left ? from_left : 1 - from_left);
    }
    segment.length += norm(plane.end - here);
    const auto direction = [&](std::uint32_t face, const SurfacePoint& path_vertex,
                               const std::array<Vec2, 3>& edges, Vec2 toward) {
      if (!path_vertex.at_vertex()) return DirectionAtVertex{};
      const std::uint32_t c = corner_at(adjacency_, face, path_vertex.vertex);
      return DirectionAtVertex{face, angle_between(edges[c], toward),
                               angle_between(-edges[previous_corner(c)], toward)};
    };
    segment.leaves = direction(strip.first_face, from, plane.first_edges, along);
    segment.arrives = direction(strip.last_face(), to, plane.last_edges, -along);
    segment.strip = std::move(strip);
    return segment;
  }

  void unfold(const FaceStrip& strip, const SurfacePoint& from, const SurfacePoint& to) {
    unfold_strip(adjacency_, strip, from, to, segment_plane_);
    for (std::size_t i = 0; i <= strip.portals.size(); ++i) {
      ++counts_.faces_unfolded;
      cancelled_ = cancelled_ || poll_.cancelled();
    }
  }

  // The part of a strip between two of its vertices, or of its ends. When both are
  // ends of one portal the path runs along that.
  static FaceStrip between(const FaceStrip& strip, const StripVertex& a, const StripVertex& b) {
    const bool from_start = a.vertex == kNone;
    const std::size_t begin = from_start ? 0 : a.last_portal + 1;
    const std::size_t end = b.first_portal;
    FaceStrip part;
    if (begin > end) {
      part.first_face = strip.face(std::max(a.first_portal, b.first_portal));
    } else {
      part.first_face = strip.face(begin);
      part.portals.assign(strip.portals.begin() + static_cast<std::ptrdiff_t>(begin),
                          strip.portals.begin() + static_cast<std::ptrdiff_t>(end));
    }
    return part;
  }

  // Pulls the path straight within a strip; appends the result to a chain that ends
  // with the path vertex `from`.
  void pull(FaceStrip strip, const SurfacePoint& from, const SurfacePoint& to, Chain& chain) {
    trim_strip(adjacency_, from, to, strip);
    unfold(strip, from, to);
    const std::size_t portals = strip.portals.size();
    const std::vector<StripVertex>& bends = funnel_.touched(segment_plane_);
    std::vector<StripVertex> stops{{{}, kNone, 0, 0}};
    for (std::size_t i = 0; i <= bends.size(); ++i) {
      const StripVertex a = stops.back();
      const StripVertex b = i < bends.size() ? bends[i] : StripVertex{{}, kNone, portals, portals};
      add_segment(strip, a, b, from, to, stops, chain);
    }
  }

  static bool is_same(const StripVertex& a, const StripVertex& b) {
    return a.vertex == b.vertex && a.first_portal == b.first_portal;
  }
  // Whether the strip leads from one stop to another, not back.
  static bool may_follow(const StripVertex& a, const StripVertex& b) {
    if (a.vertex == kNone || b.vertex == kNone) return true;
    return a.first_portal <= b.last_portal && !is_same(a, b);
  }

  SurfacePoint path_vertex_at(const StripVertex& stop, const SurfacePoint& end) const {
    return stop.vertex == kNone ? end : point_at_vertex(adjacency_, stop.vertex);
  }

  // The straight line from stop `a` to stop `b`, cut at the vertices that it happens
  // to run through.
  void add_segment(const FaceStrip& strip, const StripVertex& a, const StripVertex& b,
                   const SurfacePoint& from, const SurfacePoint& to,
                   std::vector<StripVertex>& stops, Chain& chain) {
    const std::size_t offset = a.vertex == kNone ? 0 : a.last_portal + 1;
    PathSegment whole = lay(between(strip, a, b), path_vertex_at(a, from), path_vertex_at(b, to));
    const std::size_t first_stop = stops.size();
    for (const auto& [portal, is_left] : run_through_) {
      const StripVertex& v =
          is_left ? funnel_.left_of(offset + portal) : funnel_.right_of(offset + portal);
      const bool again = stops.size() > 1 && is_same(stops[stops.size() - 2], v);
      if (!again && may_follow(stops.back(), v) && may_follow(v, b)) stops.push_back(v);
    }
    if (stops.size() == first_stop) {
      chain.segments.push_back(std::move(whole));
    } else {
      for (std::size_t i = first_stop; i <= stops.size(); ++i) {
        const StripVertex& u = stops[i - 1];
        const StripVertex& v = i < stops.size() ? stops[i] : b;
        chain.segments.push_back(
            lay(between(strip, u, v), path_vertex_at(u, from), path_vertex_at(v, to)));
        if (i < stops.size()) chain.path_vertices.push_back({path_vertex_at(v, to)});
      }
    }
    chain.path_vertices.push_back({path_vertex_at(b, to)});
    stops.push_back(b);
  }

  // The whole path, by the least fan at every vertex where there is any.
  void pull_straight(Chain& chain) {
    constexpr double kAnyAngle = std::numeric_limits<double>::infinity();
    std::vector<std::optional<Fan>> fans(chain.path_vertices.size());
    Chain result;
    result.path_vertices.push_back(chain.path_vertices.front());
    std::size_t first = 0;
    for (std::size_t i = 1; i < chain.path_vertices.size(); ++i) {
      if (i + 1 < chain.path_vertices.size()) {
        fans[i] = fans_.least(chain.path_vertices[i].place.vertex, chain.segments[i - 1].arrives,
                              chain.segments[i].leaves, kAnyAngle);
        if (fans[i]) continue;
      }
      pull(joined(chain, first, i, [&](std::size_t k) -> const Fan& { return *fans[k]; }),
           chain.path_vertices[first].place, chain.path_vertices[i].place, result);
      first = i;
    }
    chain = std::move(result);
  }

  // -- Over the vertices --------------------------------------------------------

  // Moves the path over all vertices that have a side below pi. False when there
  // is none, or none of them gained anything.
  bool cross_all_vertices(Chain& chain) {
    constexpr double kBelow = std::numbers::pi - tolerance::kStraightAngle;
    if (stopped()) return false;
    const std::size_t end = chain.path_vertices.size() - 1;
    std::vector<std::optional<Fan>> fans(chain.path_vertices.size());
    bool any = false;
    for (std::size_t i = 1; i < end; ++i) {
      cancelled_ = cancelled_ || poll_.cancelled();
      if (!std::exchange(chain.path_vertices[i].is_changed, false)) continue;
      fans[i] = fans_.least(chain.path_vertices[i].place.vertex, chain.segments[i - 1].arrives,
                            chain.segments[i].leaves, kBelow);
      any = any || fans[i];
    }
    if (!any) return false;

    // A vertex that stays divides the path into parts that do not concern each other.
    Chain result;
    result.path_vertices.push_back(chain.path_vertices.front());
    bool gained = false;
    for (std::size_t first = 0; first < end;) {
      std::size_t last = first + 1;
      while (fans[last]) ++last;
      if (last == first + 1) {
        result.take(chain, first);
      } else if (cross_vertices(chain, fans, first, last, result)) {
        gained = true;
      } else if (last > first + 2) {
        gained = cross_one_by_one(chain, fans, first, last, result) || gained;
      } else {
        result.take(chain, first);
        result.take(chain, first + 1);
      }
      first = last;
    }
    chain = std::move(result);
    return gained;
  }

  // Neither shorter nor longer, as far as rounding tells.
  static bool is_even(double before, double after) {
    return std::abs(after - before) <= before * tolerance::kLeastGain;
  }

  // Tries the fans at all path vertices between two that stay. If that is shorter, appends
  // it to `result`.
  //
  // Where the path goes through two vertices that are next to nothing apart, what
  // it gains at the first is too little to see, but unless it is moved there it never
  // comes to the second. So once for each vertex a change may be even.
  bool cross_vertices(const Chain& chain, const std::vector<std::optional<Fan>>& fans,
                      std::size_t first, std::size_t last, Chain& result) {
    if (stopped()) return false;
    double before = 0;
    for (std::size_t i = first; i < last; ++i) before += chain.segments[i].length;
    Chain part;
    part.path_vertices.push_back(chain.path_vertices[first]);
    pull(joined(chain, first, last, [&](std::size_t k) -> const Fan& { return *fans[k]; }),
         chain.path_vertices[first].place, chain.path_vertices[last].place, part);
    counts_.crossings += last - first - 1;
    double after = 0;
    for (const PathSegment& segment : part.segments) after += segment.length;
    if (!(after < before * (1 - tolerance::kLeastGain)) &&
        !(is_even(before, after) && last == first + 2 &&
          crossed_even_.insert(chain.path_vertices[first + 1].place.vertex).second))
      return false;
    result.path_vertices.back().is_changed = true;
    for (std::size_t i = 0; i < part.segments.size(); ++i) result.take(part, i);
    return true;
  }

  // Rounding among needles may spoil what a vertex next to them gains.
  bool cross_one_by_one(Chain& chain, const std::vector<std::optional<Fan>>& fans,
                        std::size_t first, std::size_t last, Chain& result) {
    bool gained = false;
    while (first < last) {
      if (first + 1 < last && cross_vertices(chain, fans, first, first + 2, result)) {
        gained = true;
        first += 2;  // the fan found there was for the segment that has just gone
      } else {
        result.take(chain, first++);
      }
    }
    return gained;
  }

  const Adjacency& adjacency_;
  Poll poll_;
  FanSearch fans_;
  Funnel funnel_;
  UnfoldedStrip segment_plane_;
  // Of the segment laid last: portals crossed at an end, and whether that is their left.
  std::vector<std::pair<std::size_t, bool>> run_through_;
  std::unordered_set<std::uint32_t> crossed_even_;  // vertices where a change was even
  bool cancelled_ = false;
  ShortenCounts counts_;
};

}  // namespace

Result<Path> shorten_path(const Adjacency& adjacency, const Path& path, const Cancel& cancel,
                          ShortenCounts* counts) {
  Shortener shortener(adjacency, cancel);
  auto result = shortener.shorten(path, true);
  if (counts != nullptr) *counts = shortener.counts();
  return result;
}

Result<Path> pull_straight(const Adjacency& adjacency, const Path& path, const Cancel& cancel) {
  return Shortener(adjacency, cancel).shorten(path, false);
}

}  // namespace geodesic
