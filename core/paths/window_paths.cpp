#include "core/paths/window_paths.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/base/tolerances.h"
#include "core/field/way_through_windows.h"

namespace geodesic {
namespace {

using Weights = std::array<double, 3>;

// The tolerance beside a line: of its length, and of the mesh's extent.
constexpr double kBesideOfWay = 1e-7;
constexpr double kBesideOfExtent = 1e-11;

Vec2 place_in(const UnfoldedTriangle& laid, const Weights& weights) {
  Vec2 place{0, 0};
  for (std::size_t i = 0; i < 3; ++i) place = place + weights[laid.corner[i]] * laid.at[i];
  return place;
}

Vec2 corner_in(const UnfoldedTriangle& laid, std::uint32_t c) {
  const auto i = std::find(laid.corner.begin(), laid.corner.end(), c) - laid.corner.begin();
  return laid.at[static_cast<std::size_t>(i)];
}

// The unfolded source of a window on the side that begins at corner c, beyond the side.
Vec2 unfolded_source(const VisibleInterval& window, const UnfoldedTriangle& laid, std::uint32_t c) {
  const Vec2 tail = corner_in(laid, c);
  const Vec2 along = unit(corner_in(laid, next_corner(c)) - tail);
  const bool is_ccw = laid.corner[1] == next_corner(laid.corner[0]);
  const Vec2 out = is_ccw ? Vec2{along.y, -along.x} : Vec2{-along.y, along.x};
  return tail + window.x * along + window.y * out;
}

Weights at_corner(std::uint32_t c) {
  Weights weights{0, 0, 0};
  weights[c] = 1;
  return weights;
}

}  // namespace

WindowPaths::WindowPaths(const Adjacency& adjacency, const Field& field, Poll& poll)
    : adjacency_(adjacency),
      field_(field),
      poll_(poll),
      windows_(field.kept_windows->table),
      refined_(field.kept_windows->is_refined ? adjacency.refined() : nullptr),
      mesh_(adjacency.triangulation()),
      surface_(refined_ != nullptr ? refined_->triangulation() : mesh_),
      extent_(norm(adjacency.mesh().box().max - adjacency.mesh().box().min)),
      same_(field.distance.are_floats() ? 2 * tolerance::kSinglePrecision : tolerance::kSameWay) {}

std::vector<WindowPaths::Place> WindowPaths::places_of(const SurfacePoint& point) const {
  if (refined_ != nullptr) return refined_->places_of(mesh_, point.face, point.bary, poll_);
  const auto first = UnfoldedTriangle::from_corner(mesh_.faces, point.face, 0);
  std::vector<Place> places{{point.face, point.bary, first, 0}};
  for (const SurfacePoint& other : in_all_faces(adjacency_, point)) {
    if (other.face == point.face) continue;
    const std::uint32_t side = corner_of(edge_under(point));
    const Halfedge over = halfedge(other.face, corner_of(edge_under(other)));
    places.push_back(
        {other.face, other.bary, first.across(mesh_.faces, over, static_cast<int>(side)), 0});
  }
  return places;
}

WindowPaths::Piece WindowPaths::piece_through(const UnfoldedTriangle& laid,
                                              const Weights& weights) const {
  const FaceRecord& face = surface_.faces[laid.face];
  const Vec2 place = place_in(laid, weights);
  Piece best;
  const auto straight_to = [&](Vec2 end, double offset, std::uint32_t vertex,
                               std::uint32_t source) {
    const double d = offset + norm(end - place);
    if (d < best.distance) best = {d, end, vertex, source};
  };
  for (std::uint32_t c = 0; c < 3; ++c) {
    // Vertices that were added are flat: no path bends there, and the field has no distance of
    // them.
    const std::uint32_t v = face.vertex[c];
    if (weights[c] == 1 || v >= field_.distance.size()) continue;
    straight_to(corner_in(laid, c), field_.distance[v], v, kNone);
  }
  const auto& sources = field_.kept_windows->sources;
  auto at = std::lower_bound(sources.begin(), sources.end(), laid.face,
                             [](const auto& a, std::uint32_t f) { return a.face < f; });
  for (; at != sources.end() && at->face == laid.face && !poll_.cancelled(); ++at) {
    straight_to(place_in(laid, at->weights), field_.sources[at->source].offset, kNone, at->source);
  }
  std::size_t windows = 0;
  for (std::uint32_t c = 0; c < 3; ++c) windows += windows_.into(halfedge(laid.face, c)).size();
  (void)poll_.cancelled_after(windows / kWindowsAStep);
  const WayThroughWindow way =
      refined_ == nullptr
          ? shortest_way_through_windows(adjacency_, windows_, {laid.face, weights, kNone})
          : shortest_way_through_windows(surface_.faces, windows_, laid.face, weights);
  // A vertex that was rounded down is no nearer than the window that comes past it.
  if (!(way.distance * (1 - same_) < best.distance)) return best;
  const std::uint32_t pseudo_source = way.window->pseudo_source;
  best = {way.distance, unfolded_source(*way.window, laid, way.corner), pseudo_source,
          pseudo_source == kNone ? way.window->source : kNone};
  // If the way does not cross the side where the straight line would, the window does not see the
  // place: the path bends at the end of the side.
  const Vec2 tail = corner_in(laid, way.corner);
  const Vec2 head = corner_in(laid, next_corner(way.corner));
  const double tail_offset = cross(best.end - place, tail - place);
  const double head_offset = cross(best.end - place, head - place);
  const double between = tail_offset - head_offset;
  constexpr double kBeside = 1e-9;  // of the side
  const bool is_at_end = std::min(way.crossing, 1 - way.crossing) <= kBeside;
  const bool is_straight =
      std::abs(tail_offset - way.crossing * between) <= kBeside * std::abs(between);
  const std::uint32_t end = way.crossing < 0.5 ? way.corner : next_corner(way.corner);
  if (is_at_end && !is_straight && face.vertex[end] < field_.distance.size()) {
    best = {way.distance, corner_in(laid, end), face.vertex[end], kNone};
  }
  return best;
}

std::optional<double> WindowPaths::distance_at(const SurfacePoint& point) const {
  if (point.at_vertex()) return field_.distance[point.vertex];
  const auto places = places_of(point);
  if (places.empty()) return std::nullopt;
  double least = kUnreached;
  for (const auto& place : places) {
    if (poll_.cancelled()) break;
    least = std::min(least, piece_through(place.laid, place.weights).distance);
  }
  return least;
}

// The source that lies at the vertex and gives it its distance; kNone if there is none.
std::uint32_t WindowPaths::source_at(std::uint32_t v) const {
  const std::uint32_t s = field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
  return s < field_.sources.size() && field_.sources[s].point.vertex == v ? s : kNone;
}

std::optional<WindowPaths::Way> WindowPaths::way_to(const SurfacePoint& target) const {
  Way way{{}, kNone, 0};
  Stop at{target.vertex, kNone};
  if (target.at_vertex()) {
    way.distance = field_.distance[target.vertex];
  } else {
    const auto stop = walk_from_point(target, way);
    if (!stop) return std::nullopt;
    at = *stop;
  }
  std::unordered_set<std::uint32_t> visited;
  for (;;) {
    way.source = at.source != kNone ? at.source : source_at(at.vertex);
    if (way.source != kNone) return way;
    if (poll_.cancelled() || !visited.insert(at.vertex).second) return std::nullopt;
    const auto stop = walk_from_vertex(at.vertex, way);
    if (!stop) return std::nullopt;
    at = *stop;
  }
}

std::optional<WindowPaths::Stop> WindowPaths::walk_from_point(const SurfacePoint& target,
                                                              Way& way) const {
  const auto places = places_of(target);
  Piece best;
  for (const Place& place : places) {
    if (poll_.cancelled()) return std::nullopt;
    const Piece piece = piece_through(place.laid, place.weights);
    if (piece.distance < best.distance) best = piece;
  }
  if (best.distance == kUnreached) return std::nullopt;
  way.distance = best.distance;
  const UnfoldedTriangle face =
      UnfoldedTriangle::from_corner(mesh_.faces, target.face, places.front().corner);
  return walk(face, place_in(face, target.bary), target.bary, best, way.legs);
}

std::optional<WindowPaths::Stop> WindowPaths::walk_from_vertex(std::uint32_t v, Way& way) const {
  Piece best;
  std::uint32_t corner = kNone;
  for (const std::uint32_t at : surface_.corners(v)) {
    if (poll_.cancelled()) return std::nullopt;
    const auto laid = UnfoldedTriangle::from_corner(surface_.faces, face_of(at), corner_of(at));
    const Piece piece = piece_through(laid, at_corner(corner_of(at)));
    if (!(piece.distance < best.distance)) continue;
    best = piece;
    corner = at;
  }
  if (corner == kNone) return std::nullopt;
  const double length = norm(best.end);
  Heading heading{corner, std::atan2(best.end.y, best.end.x)};
  if (refined_ != nullptr) {
    const auto on_mesh = refined_->heading_on_mesh(mesh_, heading, poll_);
    if (!on_mesh) return std::nullopt;
    heading = *on_mesh;
  }
  best.end = length * Vec2{std::cos(heading.angle), std::sin(heading.angle)};
  const std::uint32_t c = corner_of(heading.corner);
  const auto face = UnfoldedTriangle::from_corner(mesh_.faces, face_of(heading.corner), c);
  return walk(face, {0, 0}, at_corner(c), best, way.legs);
}

WindowPaths::Line::Line(Vec2 start, const Piece& piece_of_way, double extent)
    : from(start),
      direction(unit(piece_of_way.end - start)),
      length(norm(piece_of_way.end - start)),
      tolerance(kBesideOfWay * length + kBesideOfExtent * extent),
      piece(piece_of_way) {}

int WindowPaths::Line::exit_side(const UnfoldedTriangle& face) const {
  int out = -1;
  double widest = -1;
  for (int i = 0; i < 3; ++i) {
    const double before = signed_offset(face.at[static_cast<std::size_t>(i)]);
    const double behind = signed_offset(face.at[static_cast<std::size_t>((i + 1) % 3)]);
    if (!(before <= 0 && behind >= 0 && behind - before > widest)) continue;
    widest = behind - before;
    out = i;
  }
  return out;
}

// A piece ends at any vertex on the line whose distance agrees with the line's, even before its
// end. Rounding cannot tell whether a path that grazes a vertex bends there: along the rim of a
// hole it does on the plate, and not on the hole's wall. The next piece starts there, and decides.
std::optional<std::uint32_t> WindowPaths::vertex_on(const Line& line,
                                                    const UnfoldedTriangle& face) const {
  std::optional<std::uint32_t> nearest;
  double least = kUnreached;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t v = mesh_.faces[face.face].vertex[face.corner[i]];
    const double along = dot(line.direction, face.at[i] - line.from);
    const bool is_on_line = std::abs(line.signed_offset(face.at[i])) <= line.tolerance &&
                            along <= line.length + line.tolerance;
    if (!is_on_line || !(along < least)) continue;
    const bool is_end = v == line.piece.vertex && std::abs(along - line.length) <= line.tolerance;
    const double rounding = same_ * line.piece.distance + line.tolerance;
    const bool is_passed = along > line.tolerance &&
                           std::abs(field_.distance[v] - (line.piece.distance - along)) <= rounding;
    if (!is_end && !is_passed) continue;
    least = along;
    nearest = face.corner[i];
  }
  return nearest;
}

std::optional<Weights> WindowPaths::source_on(const Line& line,
                                              const UnfoldedTriangle& face) const {
  if (line.piece.source == kNone) return std::nullopt;
  const SurfacePoint& source = field_.sources[line.piece.source].point;
  if (source.at_vertex()) return std::nullopt;
  const auto seen = seen_from_face(adjacency_, source, face.face);
  if (!seen || !(norm(place_in(face, seen->bary) - line.piece.end) <= line.tolerance)) {
    return std::nullopt;
  }
  return seen->bary;
}

// Where the line ends in a face that has not what it leads to: that may be in a face without width
// right beside, at the same position in space. The way goes on there by a leg without length.
std::optional<WindowPaths::Stop> WindowPaths::stop_beside(const Line& line,
                                                          const UnfoldedTriangle& face,
                                                          const Weights& start,
                                                          std::vector<WayLeg>& legs) const {
  const Piece& piece = line.piece;
  if (piece.vertex != kNone && piece.vertex >= adjacency_.mesh().vertex_count())
    return std::nullopt;
  const SurfacePoint goal = piece.vertex != kNone ? point_at_vertex(adjacency_, piece.vertex)
                                                  : field_.sources[piece.source].point;
  const auto end = face.weights_at(piece.end);
  if (goal.face == kNone || !end) return std::nullopt;
  const Mesh& mesh = adjacency_.mesh();
  const double apart =
      distance(position_of(mesh, {face.face, *end, kNone}), position_of(mesh, goal));
  if (!(apart <= kBesideOfExtent * extent_)) return std::nullopt;
  legs.push_back({face.face, start, *end});
  legs.push_back({goal.face, goal.bary, goal.bary});
  return goal.at_vertex() ? Stop{goal.vertex, kNone} : Stop{kNone, piece.source};
}

std::optional<WindowPaths::Stop> WindowPaths::walk(UnfoldedTriangle face, Vec2 from, Weights start,
                                                   const Piece& piece,
                                                   std::vector<WayLeg>& legs) const {
  const Line line(from, piece, extent_);
  int out = from == face.at[0] ? 1 : line.exit_side(face);
  // A shortest path crosses a face once: so all pieces together end soon after that many legs.
  const std::size_t most_legs = 2 * mesh_.faces.size() + 2;
  while (legs.size() < most_legs && !poll_.cancelled()) {
    if (const auto end = source_on(line, face)) {
      legs.push_back({face.face, start, *end});
      return Stop{kNone, piece.source};
    }
    if (const auto corner = vertex_on(line, face)) {
      legs.push_back({face.face, start, at_corner(*corner)});
      return Stop{mesh_.faces[face.face].vertex[*corner], kNone};
    }
    if (out < 0) return std::nullopt;
    const auto tail = static_cast<std::size_t>(out);
    const std::size_t head = (tail + 1) % 3;
    const double before = line.signed_offset(face.at[tail]);
    const double behind = line.signed_offset(face.at[head]);
    const double crossing =
        behind > before ? std::clamp(-before / (behind - before), 0.0, 1.0) : 0.5;
    const Vec2 place = (1 - crossing) * face.at[tail] + crossing * face.at[head];
    if (dot(line.direction, place - from) > line.length + line.tolerance) {
      return stop_beside(line, face, start, legs);
    }
    Weights end{0, 0, 0};
    end[face.corner[tail]] = 1 - crossing;
    end[face.corner[head]] = crossing;
    legs.push_back({face.face, start, end});
    const Halfedge h = face.side(out);
    const Halfedge over = mesh_.ring(h);
    if (over == h || mesh_.ring(over) != h) return std::nullopt;
    face = face.across(mesh_.faces, over, out);
    start = {0, 0, 0};
    start[face.corner[0]] = crossing;
    start[face.corner[1]] = 1 - crossing;
    // Left or right of the one corner that is new: so it goes past a vertex on the line on one
    // side.
    out = line.signed_offset(face.at[2]) > 0 ? 1 : 2;
  }
  return std::nullopt;
}

}  // namespace geodesic
