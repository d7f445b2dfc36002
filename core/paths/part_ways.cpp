#include "core/paths/part_ways.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/base/tolerances.h"
#include "core/field/way_through_windows.h"

namespace geodesic {
namespace {

using Weights = std::array<double, 3>;

// What rounding leaves between a place and where a line says it is, of the line and of the mesh.
constexpr double kBesideOfWay = 1e-7;
constexpr double kBesideOfExtent = 1e-11;
// Distances of vertices are floats.
constexpr double kSameFloat = 2 * tolerance::kSinglePrecision;

Vec2 place_in(const UnfoldedTriangle& laid, const Weights& weights) {
  Vec2 place{0, 0};
  for (std::size_t i = 0; i < 3; ++i) place = place + weights[laid.corner[i]] * laid.at[i];
  return place;
}

Vec2 corner_in(const UnfoldedTriangle& laid, std::uint32_t c) {
  const auto i = std::find(laid.corner.begin(), laid.corner.end(), c) - laid.corner.begin();
  return laid.at[static_cast<std::size_t>(i)];
}

// Where a window on the side that begins at corner c has its source, beyond the side.
Vec2 source_of(const VisibleInterval& window, const UnfoldedTriangle& laid, std::uint32_t c) {
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

PartWays::PartWays(const Adjacency& adjacency, const Field& field, Poll& poll)
    : adjacency_(adjacency),
      field_(field),
      poll_(poll),
      windows_(field.part_windows->table),
      refined_(field.part_windows->is_refined ? adjacency.refined() : nullptr),
      mesh_(adjacency.triangulation()),
      surface_(refined_ != nullptr ? refined_->triangulation() : mesh_),
      extent_(norm(adjacency.mesh().box().max - adjacency.mesh().box().min)) {
  for (std::uint32_t s = 0; s < field.sources.size() && !poll.cancelled(); ++s) {
    const SurfacePoint& point = field.sources[s].point;
    if (point.at_vertex()) continue;
    for (const Place& place : places_of(point)) {
      source_places_.push_back({place.face, s, place.weights});
    }
  }
  std::stable_sort(source_places_.begin(), source_places_.end(),
                   [](const SourcePlace& a, const SourcePlace& b) { return a.face < b.face; });
}

std::vector<PartWays::Place> PartWays::places_of(const SurfacePoint& point) const {
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

PartWays::Piece PartWays::piece_through(const UnfoldedTriangle& laid,
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
    const std::uint32_t v = face.vertex[c];  // one that was added has no distance, and bends no way
    if (weights[c] == 1 || v >= field_.distance.size()) continue;
    straight_to(corner_in(laid, c), field_.distance[v], v, kNone);
  }
  const auto [first, last] =
      std::equal_range(source_places_.begin(), source_places_.end(), SourcePlace{laid.face, 0, {}},
                       [](const SourcePlace& a, const SourcePlace& b) { return a.face < b.face; });
  for (auto at = first; at != last && !poll_.cancelled(); ++at) {
    straight_to(place_in(laid, at->weights), field_.sources[at->source].offset, kNone, at->source);
  }
  const WayThroughWindow way =
      shortest_way_through_windows(surface_.faces, windows_, laid.face, weights);
  if (!(way.distance < best.distance)) return best;
  best = {way.distance, source_of(*way.window, laid, way.corner), way.window->pseudo_source,
          way.window->source};
  // Past the end of a side the way bends there.
  const Vec2 tail = corner_in(laid, way.corner);
  const Vec2 head = corner_in(laid, next_corner(way.corner));
  const double before = cross(best.end - place, tail - place);
  const double behind = cross(best.end - place, head - place);
  constexpr double kBeside = 1e-9;  // of the side
  const bool is_straight =
      std::abs(before - way.crossing * (before - behind)) <= kBeside * std::abs(before - behind);
  const std::uint32_t end = way.crossing < 0.5 ? way.corner : next_corner(way.corner);
  if (!is_straight && face.vertex[end] < field_.distance.size()) {
    best = {way.distance, corner_in(laid, end), face.vertex[end], kNone};
  }
  return best;
}

std::optional<double> PartWays::distance_at(const SurfacePoint& point) const {
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

// The number of a source at the vertex that its distance is from.
std::uint32_t PartWays::source_at(std::uint32_t v) const {
  const std::uint32_t s = field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
  return s < field_.sources.size() && field_.sources[s].point.vertex == v ? s : kNone;
}

std::optional<PartWays::Way> PartWays::way_to(const SurfacePoint& target) const {
  Way way{{}, kNone, 0};
  Stop at{target.vertex, kNone};
  if (target.at_vertex()) {
    way.distance = field_.distance[target.vertex];
  } else {
    const auto stop = walk_from_point(target, way);
    if (!stop) return std::nullopt;
    at = *stop;
  }
  std::unordered_set<std::uint32_t> come_to;
  for (;;) {
    way.source = at.source != kNone ? at.source : source_at(at.vertex);
    if (way.source != kNone) return way;
    if (poll_.cancelled() || !come_to.insert(at.vertex).second) return std::nullopt;
    const auto stop = walk_from_vertex(at.vertex, way);
    if (!stop) return std::nullopt;
    at = *stop;
  }
}

std::optional<PartWays::Stop> PartWays::walk_from_point(const SurfacePoint& target,
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

std::optional<PartWays::Stop> PartWays::walk_from_vertex(std::uint32_t v, Way& way) const {
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
  RefinedSurface::Heading heading{corner, std::atan2(best.end.y, best.end.x)};
  if (refined_ != nullptr) {
    const auto on_mesh = refined_->on_mesh(mesh_, heading, poll_);
    if (!on_mesh) return std::nullopt;
    heading = *on_mesh;
  }
  best.end = length * Vec2{std::cos(heading.angle), std::sin(heading.angle)};
  const std::uint32_t c = corner_of(heading.corner);
  const auto face = UnfoldedTriangle::from_corner(mesh_.faces, face_of(heading.corner), c);
  return walk(face, {0, 0}, at_corner(c), best, way.legs);
}

PartWays::Line::Line(Vec2 start, const Piece& piece_of_way, double extent)
    : from(start),
      direction(unit(piece_of_way.end - start)),
      length(norm(piece_of_way.end - start)),
      beside(kBesideOfWay * length + kBesideOfExtent * extent),
      piece(piece_of_way) {}

double PartWays::Line::left_of(Vec2 place) const { return cross(direction, place - from); }

// The side over which it leaves the face that it begins in; -1 if rounding hides it.
int PartWays::Line::way_out_of(const UnfoldedTriangle& face) const {
  int out = -1;
  double widest = -1;
  for (int i = 0; i < 3; ++i) {
    const double before = left_of(face.at[static_cast<std::size_t>(i)]);
    const double behind = left_of(face.at[static_cast<std::size_t>((i + 1) % 3)]);
    if (!(before <= 0 && behind >= 0 && behind - before > widest)) continue;
    widest = behind - before;
    out = i;
  }
  return out;
}

// A vertex on the line that is as far as the line says, be it where the piece ends or before: from
// there it goes on as from any other. What bends at a vertex on one side may go straight on the
// other, and rounding say nothing of the side.
std::optional<std::uint32_t> PartWays::vertex_on(const Line& line,
                                                 const UnfoldedTriangle& face) const {
  std::optional<std::uint32_t> nearest;
  double least = kUnreached;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 run = face.at[i] - line.from;
    const double along = dot(line.direction, run);
    if (!(std::abs(line.left_of(face.at[i])) <= line.beside) || !(along > line.beside) ||
        !(along <= line.length + line.beside) || !(along < least)) {
      continue;
    }
    const double known = field_.distance[mesh_.faces[face.face].vertex[face.corner[i]]];
    const double rounding = kSameFloat * line.piece.distance + line.beside;
    if (!(std::abs(known - (line.piece.distance - along)) <= rounding)) continue;
    least = along;
    nearest = face.corner[i];
  }
  return nearest;
}

std::optional<Weights> PartWays::source_on(const Line& line, const UnfoldedTriangle& face) const {
  if (line.piece.source == kNone) return std::nullopt;
  const SurfacePoint& source = field_.sources[line.piece.source].point;
  if (source.at_vertex()) return std::nullopt;
  const auto seen = seen_from_face(adjacency_, source, face.face);
  if (!seen || !(norm(place_in(face, seen->bary) - line.piece.end) <= line.beside)) {
    return std::nullopt;
  }
  return seen->bary;
}

std::optional<PartWays::Stop> PartWays::walk(UnfoldedTriangle face, Vec2 from, Weights start,
                                             const Piece& piece, std::vector<WayLeg>& legs) const {
  const Line line(from, piece, extent_);
  int out = from == face.at[0] ? 1 : line.way_out_of(face);
  // It crosses a face once.
  for (std::size_t left = mesh_.faces.size(); left > 0 && out >= 0 && !poll_.cancelled(); --left) {
    if (const auto end = source_on(line, face)) {
      legs.push_back({face.face, start, *end});
      return Stop{kNone, piece.source};
    }
    if (const auto corner = vertex_on(line, face)) {
      legs.push_back({face.face, start, at_corner(*corner)});
      return Stop{mesh_.faces[face.face].vertex[*corner], kNone};
    }
    const auto tail = static_cast<std::size_t>(out);
    const std::size_t head = (tail + 1) % 3;
    const double before = line.left_of(face.at[tail]);
    const double behind = line.left_of(face.at[head]);
    const double crossing =
        behind > before ? std::clamp(-before / (behind - before), 0.0, 1.0) : 0.5;
    const Vec2 place = (1 - crossing) * face.at[tail] + crossing * face.at[head];
    if (dot(line.direction, place - from) > line.length + line.beside) return std::nullopt;
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
    // By the side of the one corner that is new: round a vertex on the line it goes on one side.
    out = line.left_of(face.at[2]) > 0 ? 1 : 2;
  }
  return std::nullopt;
}

}  // namespace geodesic
