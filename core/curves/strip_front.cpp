#include "core/curves/strip_front.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/tolerances.h"
#include "core/curves/strips_on_edges.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic {
namespace {

// Of an edge's length: a strip that is so narrow, square to its flow, is a line. What it would
// bring comes past the vertices at its sides, longer by no more than its width.
constexpr double kLeastStrip = 1e-13;

// What waits: a strip, or a vertex whose bound is handed to its neighbours.
struct Waiting {
  double key;
  std::uint32_t number;
  bool is_vertex;

  // The nearest first, and of those as near always the same.
  friend bool operator<(const Waiting& a, const Waiting& b) {
    if (a.key != b.key) return a.key > b.key;
    if (a.is_vertex != b.is_vertex) return b.is_vertex;
    return a.number > b.number;
  }
};

// A side of the face that a strip crosses, from one end of its base to the apex; the part of it
// that the strip leaves by, and the wave there. `out`: the share of its direction square to the
// side.
struct Leaving {
  Halfedge side;
  std::uint32_t origin;  // the vertex that the part is counted from
  double length;
  double begin;
  double end;
  double value;  // at `begin`
  double along;
  double out;
};

class StripFront {
 public:
  StripFront(const Adjacency& adjacency, const SourceLines& lines, const StripLimits& limits,
             Poll& poll)
      : adjacency_(adjacency), lines_(lines), limits_(limits), poll_(poll) {
    const std::size_t vertices = adjacency.mesh().vertex_count();
    polled_assign(bound_, vertices, kUnreached, poll);
    polled_assign(met_, vertices, kUnreached, poll);
    polled_assign(met_from_, vertices, kNone, poll);
    if (adjacency.report().edges_non_manifold > 0) on_edges_.emplace(adjacency, poll);
  }

  void start(std::span<const Source> sources) {
    for (const Source& source : sources) {
      if (source.point.at_vertex()) {
        lower(source.point.vertex, source.offset);
        continue;
      }
      for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
        if (poll_.cancelled()) return;
        for (std::uint32_t c = 0; c < 3; ++c) {
          lower(adjacency_.face(place.face).vertex[c],
                source.offset + distance_to_corner(adjacency_.mesh(), place, c));
        }
      }
    }
    for (std::uint32_t s = 0; s < lines_.segments.size() && !poll_.cancelled(); ++s) {
      const Halfedge along = lines_.segments[s].along();
      if (along != kNone) {
        leave_edge(along, s);
      } else {
        leave_within(s);
      }
    }
  }

  // False when there were too many.
  bool run() {
    const std::uint64_t vertices = bound_.size();
    std::uint64_t settled = 0;  // a vertex may wait several times
    while (!queue_.empty() && !poll_.cancelled(std::min(settled, vertices), vertices)) {
      std::pop_heap(queue_.begin(), queue_.end());
      const Waiting next = queue_.back();
      queue_.pop_back();
      if (next.is_vertex) {
        if (next.key == bound_[next.number]) relax(next.number);
        ++settled;
        continue;
      }
      if (passed_ >= limits_.most) return false;
      pass(next.number);
    }
    return true;
  }

  [[nodiscard]] std::vector<LineStrip> take_strips() {
    for (const std::uint32_t number : free_) strips_[number].into = kNone;
    return std::move(strips_);
  }

  [[nodiscard]] std::vector<MetVertex> met() const {
    std::vector<MetVertex> vertices;
    for (std::uint32_t v = 0; v < met_.size() && !poll_.cancelled(); ++v) {
      // What is farther than along an edge is on no shortest path. A line of flow along an edge is
      // as long as the way along it, but for rounding.
      const double along_edge = bound_[v] * (1 + tolerance::kSameWay);
      if (met_[v] == kUnreached || met_[v] > along_edge || met_[v] > limits_.max) continue;
      vertices.push_back({v, met_[v], lines_.segments[met_from_[v]].item});
    }
    return vertices;
  }

 private:
  void lower(std::uint32_t vertex, double distance) {
    if (!(distance < bound_[vertex]) || !(distance <= limits_.max)) return;
    bound_[vertex] = distance;
    wait({distance, vertex, true});
  }

  void wait(const Waiting& waiting) {
    if (!has_room_for_one(queue_)) return;
    queue_.push_back(waiting);
    std::push_heap(queue_.begin(), queue_.end());
  }

  // False where the poll stops it.
  template <class Value>
  [[nodiscard]] bool has_room_for_one(std::vector<Value>& values) {
    if (values.size() < values.capacity()) return true;
    const std::size_t more = std::max<std::size_t>(values.capacity(), 64);
    if (!poll_.may_take(2 * more * sizeof(Value))) return false;
    values.reserve(values.size() + more);
    return true;
  }

  void meet(std::uint32_t vertex, double distance, std::uint32_t segment) {
    distance = std::max(distance, 0.0);
    lower(vertex, distance);
    if (!(distance < met_[vertex])) return;
    met_[vertex] = distance;
    met_from_[vertex] = segment;
  }

  // A step of Dijkstra's along the edges: bounds for where no strip has come yet.
  void relax(std::uint32_t vertex) {
    const auto positions = adjacency_.mesh().positions();
    for (const std::uint32_t corner : adjacency_.corners(vertex)) {
      if (poll_.cancelled()) return;
      const FaceRecord& face = adjacency_.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      for (const std::uint32_t v : {face.vertex[next_corner(c)], face.vertex[previous_corner(c)]}) {
        lower(v, bound_[vertex] + distance(positions[vertex], positions[v]));
      }
    }
  }

  // Both ways from a segment along an edge, into all faces there.
  void leave_edge(Halfedge h, std::uint32_t s) {
    const LineSegment& segment = lines_.segments[s];
    const FaceOnBase over = FaceOnBase::of(adjacency_, h);
    const std::uint32_t n = next_corner(corner_of(h));
    const auto [begin, end] = std::minmax({segment.from[n] * over.base, segment.to[n] * over.base});
    const Leaving leaving{h, adjacency_.tail(h), over.base, begin, end, 0, 0, 1};
    come(h, leaving, kNone, s, 0);
  }

  // From a segment inside a face to its three sides, both ways.
  void leave_within(std::uint32_t s) {
    const LineSegment& segment = lines_.segments[s];
    const std::uint32_t f = segment.face;
    if (lines_.has_face(f)) return;
    const FaceOnBase over = FaceOnBase::of(adjacency_, halfedge(f, 0));
    std::array<BesideSegment, 3> corner{};
    for (std::uint32_t c = 0; c < 3; ++c) {
      std::array<double, 3> bary{};
      bary[c] = 1;
      corner[c] = beside(over, segment, bary);
      const double slack = kStripSlack * over.base;
      if (corner[c].length > 0 && corner[c].along >= -slack &&
          corner[c].along <= corner[c].length + slack) {
        meet(adjacency_.face(f).vertex[c], std::abs(corner[c].aside), s);
      }
    }
    const double length = corner[0].length;
    if (!(length > 0)) return;
    const std::array<double, 3> sides{over.base, over.right, over.left};
    for (std::uint32_t c = 0; c < 3; ++c) {
      const BesideSegment& a = corner[c];
      const BesideSegment& b = corner[next_corner(c)];
      for (const double sign : {1.0, -1.0}) {
        // The part of the side, from 0 to 1, whose foot is on the segment, and that is on this
        // side.
        double first = 0;
        double last = 1;
        const auto keep_above = [&](double at_a, double at_b, double least) {
          if (at_a < least && at_b < least) {
            last = -1;
          } else if (at_a < least) {
            first = std::max(first, (least - at_a) / (at_b - at_a));
          } else if (at_b < least) {
            last = std::min(last, (at_a - least) / (at_a - at_b));
          }
        };
        keep_above(a.along, b.along, 0);
        keep_above(-a.along, -b.along, -length);
        keep_above(sign * a.aside, sign * b.aside, 0);
        if (!(first < last)) continue;
        const double side = sides[c];
        const double along = sign * (b.aside - a.aside) / side;
        // The face lies on the left of its sides: outwards is to the right.
        const double out = sign * (a.along - b.along) / side;
        const double value = sign * (a.aside + first * (b.aside - a.aside));
        leave({halfedge(f, c), adjacency_.face(f).vertex[c], side, first * side, last * side,
               std::max(value, 0.0), along, out},
              kNone, s, 0);
      }
    }
  }

  void leave(const Leaving& leaving, std::uint32_t parent, std::uint32_t segment,
             std::uint32_t crossed) {
    const Halfedge into = adjacency_.ring(leaving.side);
    if (into == leaving.side || crossed > adjacency_.faces().size()) return;
    come(into, leaving, parent, segment, crossed);
  }

  // To an edge, over which a strip goes once it is its turn, into all faces from `into` on but that
  // of the last.
  void come(Halfedge into, const Leaving& leaving, std::uint32_t parent, std::uint32_t segment,
            std::uint32_t crossed) {
    const double norm = std::sqrt(leaving.along * leaving.along + leaving.out * leaving.out);
    if (!(leaving.out > 0) || !(norm > 0)) return;
    LineStrip strip{
        leaving.begin, leaving.end, leaving.value, leaving.along / norm, leaving.out / norm, into,
        parent,        segment,     crossed};
    if (adjacency_.tail(into) != leaving.origin) strip = mirrored(strip, leaving.length);
    if (!trim(strip, leaving.length)) return;
    if (!(strip.least() <= limits_.max)) return;
    const std::uint32_t number = add(strip);
    if (number != kNone) wait({strip.least(), number, false});
  }

  // Counted from the other end of an edge of that length.
  [[nodiscard]] static LineStrip mirrored(LineStrip strip, double length) {
    strip.value = strip.at(strip.end);
    const double begin = strip.begin;
    strip.begin = length - strip.end;
    strip.end = length - begin;
    strip.b = -strip.b;
    return strip;
  }

  // Cuts off what is farther than along the edge from one of its ends. False if nothing is left.
  [[nodiscard]] bool trim(LineStrip& strip, double length) const {
    const double at_tail = bound_[adjacency_.tail(strip.into)];
    const double at_head = bound_[adjacency_.head(strip.into)];
    const double rounding = tolerance::kSameWay * (length + std::abs(strip.value));
    const double begin = strip.begin;
    double end = strip.end;
    double first = begin;
    // What the wave gains on the way along the edge in a unit of it, without cancellation.
    const double square = strip.c * strip.c;
    const double gain = strip.b > 0 ? square / (1 + strip.b) : 1 - strip.b;
    const double gain_back = strip.b < 0 ? square / (1 - strip.b) : 1 + strip.b;
    // strip.at(p) < at_tail + p
    const double late = strip.value - (at_tail + begin) - rounding;
    if (late > 0) first = begin + late / gain;
    // strip.at(p) < at_head + length - p
    const double early = strip.at(end) - (at_head + length - end) - rounding;
    if (early > 0) end -= early / gain_back;
    if (!((end - first) * strip.c > kLeastStrip * length)) return false;
    strip.value = strip.at(first);
    strip.begin = first;
    strip.end = end;
    return true;
  }

  // Its number, or kNone where the poll stops it.
  [[nodiscard]] std::uint32_t add(const LineStrip& strip) {
    if (!free_.empty()) {
      const std::uint32_t number = free_.back();
      free_.pop_back();
      strips_[number] = strip;
      return number;
    }
    if (!has_room_for_one(strips_)) return kNone;
    strips_.push_back(strip);
    return static_cast<std::uint32_t>(strips_.size() - 1);
  }

  // A strip goes over its edge into each of the faces.
  void pass(std::uint32_t number) {
    LineStrip strip = strips_[number];
    const Halfedge first = strip.into;
    const std::uint32_t tail = adjacency_.tail(first);
    const auto positions = adjacency_.mesh().positions();
    const double length = distance(positions[tail], positions[adjacency_.head(first)]);
    const bool is_some = trim(strip, length) && keep_nearer(strip, length);
    const bool is_from_edge = strip.crossed == 0 && lines_.segments[strip.segment].along() != kNone;
    bool is_used = false;
    for (Halfedge g = first; is_some && !poll_.cancelled();) {
      const Halfedge next = adjacency_.ring(g);
      if (next == first && !is_from_edge) break;  // it came from there
      if (!lines_.has_face(face_of(g))) {
        LineStrip into = adjacency_.tail(g) == tail ? strip : mirrored(strip, length);
        into.into = g;
        const std::uint32_t own = is_used ? add(into) : number;
        if (own == kNone) return;
        strips_[own] = into;
        is_used = true;
        ++passed_;
        cross(own);
      }
      if (next == first) break;
      g = next;
    }
    if (is_used) return;
    ++passed_;
    free_.push_back(number);  // no other came from it
  }

  // False if nothing is left.
  [[nodiscard]] bool keep_nearer(LineStrip& strip, double length) {
    if (!on_edges_) return true;
    StripOnEdge on_edge{strip.begin, strip.end, strip.value, strip.at(strip.end)};
    const double least = kLeastStrip * length / strip.c;
    if (!on_edges_->keep_nearer(strip.into, length, least, on_edge, poll_)) return false;
    const double begin = std::max(on_edge.begin, strip.begin);
    strip.value = strip.at(begin);
    strip.begin = begin;
    strip.end = std::min(on_edge.end, strip.end);
    return strip.begin < strip.end;
  }

  void cross(std::uint32_t number) {
    const LineStrip strip = strips_[number];
    const FaceOnBase over = FaceOnBase::of(adjacency_, strip.into);
    const Halfedge h = strip.into;
    const std::uint32_t f = face_of(h);
    const std::uint32_t c = corner_of(h);
    const double turn = over.apex_y * (strip.b / strip.c);
    // Where the line of flow through the apex crosses the base, from both of its ends.
    const double split = over.apex_x - turn;
    const double split_back = over.apex_back + turn;
    const auto value_at = [&](double x, double y) {
      return strip.value + strip.b * (x - strip.begin) + strip.c * y;
    };
    const double slack = kStripSlack * over.base;
    if (strip.begin - slack <= split && split <= strip.end + slack) {
      meet(adjacency_.apex(h), value_at(over.apex_x, over.apex_y), strip.segment);
    }
    const std::uint32_t parent = limits_.keep_strips ? number : kNone;
    if (strip.begin < split && split > 0) {
      const double x = over.apex_x / over.left;
      const double y = over.apex_y / over.left;
      const double first = std::min(over.left * (strip.begin / split), over.left);
      const double last =
          strip.end < split ? std::min(over.left * (strip.end / split), over.left) : over.left;
      leave(
          {halfedge(f, previous_corner(c)), adjacency_.tail(h), over.left, first, last,
           value_at(first * x, first * y), strip.b * x + strip.c * y, strip.c * split / over.left},
          parent, strip.segment, strip.crossed + 1);
    }
    if (strip.end > split && split_back > 0) {
      const double x = -over.apex_back / over.right;
      const double y = over.apex_y / over.right;
      const double first =
          std::min(over.right * ((over.base - strip.end) / split_back), over.right);
      const double last =
          strip.begin > split
              ? std::min(over.right * ((over.base - strip.begin) / split_back), over.right)
              : over.right;
      leave({halfedge(f, next_corner(c)), adjacency_.head(h), over.right, first, last,
             value_at(over.base + first * x, first * y), strip.b * x + strip.c * y,
             strip.c * split_back / over.right},
            parent, strip.segment, strip.crossed + 1);
    }
    if (!limits_.keep_strips) free_.push_back(number);
  }

  const Adjacency& adjacency_;
  const SourceLines& lines_;
  const StripLimits& limits_;
  Poll& poll_;
  std::vector<double> bound_;  // by vertex: the length of some way there
  std::vector<double> met_;    // by vertex: the least straight way by a strip
  std::vector<std::uint32_t> met_from_;
  std::vector<Waiting> queue_;  // a heap
  std::vector<LineStrip> strips_;
  std::vector<std::uint32_t> free_;
  std::uint64_t passed_ = 0;               // strips, or faces that they went over if more
  std::optional<StripsOnEdges> on_edges_;  // only where strips may meet again
};

// As thin as core/base says that rounding decides.
bool is_thin(const FaceRecord& face) { return !(face.area2 > tolerance::kThin * face.longest2()); }

}  // namespace

bool may_bend(const Adjacency& adjacency, std::uint32_t vertex, Poll& poll) {
  if (adjacency.is_pinched(vertex)) return true;
  double angles = 0;
  for (const std::uint32_t corner : adjacency.corners(vertex)) {
    if (poll.cancelled()) return true;
    const FaceRecord& face = adjacency.face(face_of(corner));
    const std::uint32_t c = corner_of(corner);
    if (is_thin(face)) return true;
    angles += corner_angle(face, c);
    for (const Halfedge side : {corner, halfedge(face_of(corner), previous_corner(c))}) {
      // In one other face, neither more nor fewer.
      const Halfedge across = adjacency.ring(side);
      if (across == side || adjacency.ring(across) != side) return true;
    }
  }
  return angles > 2 * std::numbers::pi * (1 + tolerance::kSaddle);
}

Result<StripsOfLines> spread_strips(const Adjacency& adjacency, std::span<const Source> sources,
                                    std::shared_ptr<const SourceLines> lines,
                                    const StripLimits& limits, const Cancel& cancel) {
  Poll poll(cancel, 256);
  StripFront front(adjacency, *lines, limits, poll);
  if (poll.stopped()) return fail_stopped(poll);
  StripsOfLines result;
  front.start(sources);
  result.is_complete = front.run();
  if (poll.stopped()) return fail_stopped(poll);
  if (!result.is_complete && limits.fail_beyond) {
    return fail_limit(ErrorCode::too_large,
                      "the waves from the lines part too often at edges of three faces and more; "
                      "points as sources, and the methods dijkstra, fast_marching and steiner, "
                      "take less",
                      limits.most, limits.most + 1);
  }
  result.met = front.met();
  std::vector<LineStrip> strips;
  if (limits.keep_strips) strips = front.take_strips();
  result.waves = std::make_shared<LineWaves>(adjacency, std::move(lines),
                                             static_cast<std::uint32_t>(sources.size()),
                                             std::move(strips), limits.keep_strips, poll);
  if (poll.stopped()) return fail_stopped(poll);
  return result;
}

}  // namespace geodesic
