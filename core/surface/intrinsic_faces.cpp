#include "core/surface/intrinsic_faces.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/mesh/mesh.h"
#include "core/surface/triangulation.h"

namespace geodesic {
namespace {

DoubleDouble squared_distance(Vec3 p, Vec3 q) {
  const DoubleDouble x = DoubleDouble::sum(p.x, -q.x);
  const DoubleDouble y = DoubleDouble::sum(p.y, -q.y);
  const DoubleDouble z = DoubleDouble::sum(p.z, -q.z);
  return x * x + y * y + z * z;
}

// The dot product of two sides, from the squares of them and of the third. Off by some 2^-104 of
// the largest of them, which is what the products that it goes into are off by anyway.
DoubleDouble dot_of(DoubleDouble side2, DoubleDouble other2, DoubleDouble opposite2) {
  const DoubleDouble both = DoubleDouble::sum(side2.high, other2.high);
  const DoubleDouble rest = DoubleDouble::sum(both.high, -opposite2.high);
  const double low = (rest.low + both.low) + ((side2.low + other2.low) - opposite2.low);
  return DoubleDouble::sum(0.5 * rest.high, 0.5 * low);
}

// Twice the area, squared.
struct Area {
  DoubleDouble squared;
  double rounding2;  // what that may be off by

  // Twice the area, and what that may be off by.
  [[nodiscard]] double twice() const { return std::sqrt(std::max(squared.high, 0.0)); }
  [[nodiscard]] double rounding() const {
    return std::min(std::sqrt(rounding2), rounding2 / twice());
  }
};

// From the two shorter sides: the longest one's rounding would be a large part of a needle's.
Area area_of(DoubleDouble a, DoubleDouble b, DoubleDouble c) {
  if (a.high > c.high) std::swap(a, c);
  if (b.high > c.high) std::swap(b, c);
  const DoubleDouble dot = dot_of(a, b, c);
  return {a * b - dot * dot, tolerance::kDoubleDouble * a.high * b.high};
}

// At each corner, the dot product of the two sides that leave it (FaceRecord::dot).
std::array<double, 3> corner_products(const SquaredSides& sides) {
  return {dot_of(sides[0], sides[2], sides[1]).high, dot_of(sides[1], sides[0], sides[2]).high,
          dot_of(sides[2], sides[1], sides[0]).high};
}

// The same, as a face record has it: mostly no digits are lost between plain doubles.
double area_of(const std::array<double, 3>& dot, const SquaredSides& sides) {
  const auto [p, q, w] = dot;
  const double squared = p * q + p * w + q * w;
  const double of_terms = std::abs(p * q) + std::abs(p * w) + std::abs(q * w);
  constexpr double kLost = 0.25;  // two bits
  if (squared > kLost * of_terms) return std::sqrt(squared);
  return area_of(sides[0], sides[1], sides[2]).twice();
}

}  // namespace

SideLengths::SideLengths(std::span<const Vec3> positions, std::size_t face_count, Poll& poll)
    : positions_(positions), sides_(count_blocks(face_count)) {
  polled_assign(place_, face_count, kNone, poll);
  // Of scans, four faces in ten are changed.
  if (!poll.may_take(face_count / 2 * sizeof(SquaredSides))) return;
  for (std::vector<SquaredSides>& block : sides_) block.reserve(std::min(kBlock, face_count) / 2);
}

SquaredSides SideLengths::squared(std::uint32_t face, const FaceRecord& record) const {
  if (place_[face] != kNone) return sides_[face / kBlock][place_[face]];
  SquaredSides sides;
  for (std::uint32_t c = 0; c < 3; ++c) {
    sides[c] =
        squared_distance(positions_[record.vertex[c]], positions_[record.vertex[next_corner(c)]]);
  }
  return sides;
}

void SideLengths::set(std::uint32_t face, const SquaredSides& sides) {
  std::vector<SquaredSides>& block = sides_[face / kBlock];
  if (place_[face] == kNone) {
    place_[face] = static_cast<std::uint32_t>(block.size());
    block.push_back(sides);
  } else {
    block[place_[face]] = sides;
  }
}

// With a at the origin and b on the x axis, c and d are at (dot / |ab|, area / |ab|) on either side
// of it, where the dot products are those at a. Or from b, if the four lengths there are less.
Flipped flip_diagonal(const Quad& quad) {
  const Area one = area_of(quad.ab2, quad.bc2, quad.ca2);
  const Area other = area_of(quad.ab2, quad.bd2, quad.ad2);
  const DoubleDouble at_a1 = dot_of(quad.ab2, quad.ca2, quad.bc2);
  const DoubleDouble at_a2 = dot_of(quad.ab2, quad.ad2, quad.bd2);
  const bool from_a = quad.ca2.high * quad.ad2.high <= quad.bc2.high * quad.bd2.high;
  const DoubleDouble dot1 = from_a ? at_a1 : quad.ab2 - at_a1;
  const DoubleDouble dot2 = from_a ? at_a2 : quad.ab2 - at_a2;
  const DoubleDouble to_c2 = from_a ? quad.ca2 : quad.bc2;
  const DoubleDouble to_d2 = from_a ? quad.ad2 : quad.bd2;
  // By a power of two, so that the product of four squares stays within range.
  const double scale = std::ldexp(1.0, -std::ilogb(quad.ab2.high));
  const DoubleDouble areas =
      square_root((one.squared * scale) * (other.squared * scale)) * (1 / scale);
  const DoubleDouble across = (dot1 * dot2 - areas) / quad.ab2;
  Flipped flipped;
  flipped.cd2 = (to_c2 + to_d2) - across * 2;

  const double area1 = one.twice();
  const double area2 = other.twice();
  const SquaredSides left{quad.ad2, flipped.cd2, quad.ca2};
  const SquaredSides right{quad.bc2, flipped.cd2, quad.bd2};
  flipped.dot_a = corner_products(left);
  flipped.dot_b = corner_products(right);
  flipped.area_a = area_of(flipped.dot_a, left);
  flipped.area_b = area_of(flipped.dot_b, right);
  // The angles at a add up to less than pi, and those at b.
  flipped.is_convex =
      at_a1.high * area2 + area1 * at_a2.high > 0 &&
      (quad.ab2.high - at_a1.high) * area2 + area1 * (quad.ab2.high - at_a2.high) > 0;

  // What c - d may be off by turns what is beyond it, the more the thinner the new faces are.
  const double longest2 =
      std::max({quad.bc2.high, quad.ca2.high, quad.ad2.high, quad.bd2.high, flipped.cd2.high});
  const double least = std::min(flipped.area_a, flipped.area_b);
  const double of_cd2 = tolerance::kDoubleDouble * (to_c2.high + to_d2.high) +
                        (tolerance::kDoubleDouble * std::abs(dot1.high * dot2.high) +
                         one.rounding() * area2 + area1 * other.rounding()) /
                            quad.ab2.high;
  flipped.error = of_cd2 / (2 * std::sqrt(flipped.cd2.high)) * (std::sqrt(longest2) / least);
  return flipped;
}

// Such faces lie on each other where both faces of an edge have been cut there, each at a vertex of
// its own. The edge between these two is shorter; and beyond their other sides there are faces with
// a width, or others without one, which flips come to in the end.
bool is_between_flats(std::span<const FaceRecord> faces, Halfedge h) {
  const auto is_longest_of_flat = [faces](Halfedge side) {
    const FaceRecord& face = faces[face_of(side)];
    return face.area2 <= tolerance::kZeroArea * face.longest2() &&
           face.longest_side() == corner_of(side);
  };
  return is_longest_of_flat(h) && is_longest_of_flat(faces[face_of(h)].ring[corner_of(h)]);
}

namespace {

// Sides of faces on their way to other places, so that whoever points at one points at its new
// place afterwards.
template <std::size_t kMost>
class MovedSides {
 public:
  explicit MovedSides(std::span<FaceRecord> faces) : faces_(faces) {}

  void add(Halfedge from, Halfedge to) { moved_[count_++] = {from, to, 0, 0}; }

  // Finds who is before and after each on its edge, before anything is written. False where an edge
  // is in very many faces: each of its flips would ask them all.
  [[nodiscard]] bool find_neighbours() {
    for (Moved& m : all()) {
      m.next = now(ring(m.from));
      Halfedge p = m.from;
      std::size_t faces = 1;
      for (; ring(p) != m.from && faces <= Triangulation::kCrowd; ++faces) p = ring(p);
      if (faces > Triangulation::kCrowd) return false;
      m.before = now(p);
    }
    return true;
  }

  void join() {
    for (const Moved& m : all()) {
      ring(m.to) = m.next;
      ring(m.before) = m.to;
    }
  }

 private:
  struct Moved {
    Halfedge from;
    Halfedge to;
    Halfedge next;
    Halfedge before;
  };
  [[nodiscard]] std::span<Moved> all() { return std::span(moved_).first(count_); }
  [[nodiscard]] Halfedge& ring(Halfedge h) { return faces_[face_of(h)].ring[corner_of(h)]; }
  [[nodiscard]] Halfedge now(Halfedge old) {
    for (const Moved& m : all()) {
      if (m.from == old) return m.to;
    }
    return old;
  }

  std::span<FaceRecord> faces_;
  std::array<Moved, kMost> moved_{};
  std::size_t count_ = 0;
};

bool loses_a_length(const FaceRecord& face) {
  return face.loses_length(0) || face.loses_length(1) || face.loses_length(2);
}

}  // namespace

bool flip_edge(std::span<FaceRecord> faces, Halfedge h, SideLengths& lengths) {
  const std::uint32_t f = face_of(h);
  const Halfedge across = faces[f].ring[corner_of(h)];
  const std::uint32_t g = face_of(across);
  const FaceRecord one = faces[f];
  const FaceRecord other = faces[g];
  // Corners of a, b and the apex in either face, whatever their windings.
  const std::uint32_t a1 = corner_of(h);
  const std::uint32_t b1 = next_corner(a1);
  const std::uint32_t c1 = previous_corner(a1);
  const bool opposed = other.vertex[corner_of(across)] != one.vertex[a1];
  const std::uint32_t a2 = opposed ? next_corner(corner_of(across)) : corner_of(across);
  const std::uint32_t b2 = opposed ? corner_of(across) : next_corner(corner_of(across));
  const std::uint32_t d2 = previous_corner(corner_of(across));

  const auto of_one = lengths.squared(f, one);
  const auto of_other = lengths.squared(g, other);
  const Quad quad{.ab2 = of_one[a1],
                  .bc2 = of_one[b1],
                  .ca2 = of_one[c1],
                  .ad2 = of_other[opposed ? a2 : d2],
                  .bd2 = of_other[opposed ? d2 : b2]};
  if (!(quad.ab2.high > 0)) return false;
  const Flipped flipped = flip_diagonal(quad);
  FaceRecord left = one;
  FaceRecord right = other;
  left.dot = flipped.dot_a;
  left.area2 = flipped.area_a;
  right.dot = flipped.dot_b;
  right.area2 = flipped.area_b;
  const bool are_flat = is_between_flats(faces, h);
  // Written so that what is not a number fails.
  const bool is_better = flipped.is_convex &&
                         left.area2 > tolerance::kFlippedHeight * left.longest2() &&
                         right.area2 > tolerance::kFlippedHeight * right.longest2();
  if (!(is_better || are_flat) || loses_a_length(left) || loses_a_length(right)) return false;
  // No more than their heights.
  const double own_error =
      are_flat ? std::min(std::max(one.area2, other.area2) / quad.ab2.high, flipped.error)
               : flipped.error;
  const double error = double{std::max(one.error, other.error)} + own_error;
  if (!(error <= tolerance::kFlips)) return false;

  // c - a, a - d in the face of h; d - b, b - c in the other.
  const auto opposite = [](std::uint32_t face, std::uint32_t apex) {
    return halfedge(face, next_corner(apex));
  };
  MovedSides<4> moved(faces);
  moved.add(opposite(f, b1), halfedge(f, 2));
  moved.add(opposite(g, b2), halfedge(f, 0));
  moved.add(opposite(g, a2), halfedge(g, 2));
  moved.add(opposite(f, a1), halfedge(g, 0));
  if (!moved.find_neighbours()) return false;
  const std::uint32_t a = one.vertex[a1];
  const std::uint32_t b = one.vertex[b1];
  const std::uint32_t c = one.vertex[c1];
  const std::uint32_t d = other.vertex[d2];
  left.vertex = {a, d, c};
  right.vertex = {b, c, d};
  left.error = right.error = static_cast<float>(error);
  left.ring[1] = halfedge(g, 1);
  right.ring[1] = halfedge(f, 1);
  faces[f] = left;
  faces[g] = right;
  lengths.set(f, {quad.ad2, flipped.cd2, quad.ca2});
  lengths.set(g, {quad.bc2, flipped.cd2, quad.bd2});
  moved.join();
  return true;
}

namespace {

void set_shape(FaceRecord& face, const SquaredSides& sides) {
  face.dot = corner_products(sides);
  face.area2 = area_of(face.dot, sides);
}

void join(std::span<FaceRecord> faces, Halfedge a, Halfedge b) {
  faces[face_of(a)].ring[corner_of(a)] = b;
  faces[face_of(b)].ring[corner_of(b)] = a;
}

}  // namespace

// From a corner, v is at the sum of the two sides that leave it, times the weights of their ends.
// Its squared distance is that of a sum of vectors, of which all products are known.
bool put_into_face(std::span<FaceRecord> faces, std::uint32_t f, double weight_b, double weight_c,
                   std::uint32_t v, std::uint32_t new_faces, SideLengths& lengths) {
  const FaceRecord old = faces[f];
  const auto [ab2, bc2, ca2] = lengths.squared(f, old);
  const DoubleDouble b = weight_b;
  const DoubleDouble c = weight_c;
  const DoubleDouble a = DoubleDouble(1) - b - c;
  const auto distance2 = [](DoubleDouble p, DoubleDouble p2, DoubleDouble q, DoubleDouble q2,
                            DoubleDouble pq) { return p * p * p2 + q * q * q2 + p * q * pq * 2; };
  const DoubleDouble to_a2 = distance2(b, ab2, c, ca2, dot_of(ab2, ca2, bc2));
  const DoubleDouble to_b2 = distance2(a, ab2, c, bc2, dot_of(ab2, bc2, ca2));
  const DoubleDouble to_c2 = distance2(a, ca2, b, bc2, dot_of(ca2, bc2, ab2));
  const std::uint32_t g = new_faces;
  const std::uint32_t h = new_faces + 1;
  faces[g] = faces[h] = old;
  MovedSides<2> moved(faces);
  moved.add(halfedge(f, 1), halfedge(g, 0));
  moved.add(halfedge(f, 2), halfedge(h, 0));
  if (!moved.find_neighbours()) return false;
  moved.join();
  const auto [at_a, at_b, at_c] = old.vertex;
  faces[f].vertex = {at_a, at_b, v};
  faces[g].vertex = {at_b, at_c, v};
  faces[h].vertex = {at_c, at_a, v};
  join(faces, halfedge(f, 1), halfedge(g, 2));
  join(faces, halfedge(g, 1), halfedge(h, 2));
  join(faces, halfedge(h, 1), halfedge(f, 2));
  const auto set = [&](std::uint32_t face, const SquaredSides& sides) {
    set_shape(faces[face], sides);
    lengths.set(face, sides);
  };
  set(f, {ab2, to_b2, to_a2});
  set(g, {bc2, to_c2, to_b2});
  set(h, {ca2, to_a2, to_c2});
  return true;
}

bool put_on_edge(std::span<FaceRecord> faces, std::span<const Halfedge> ring, std::uint32_t v,
                 std::uint32_t new_faces, SideLengths& lengths) {
  for (const Halfedge h : ring) {
    MovedSides<1> moved(faces);
    moved.add(halfedge(face_of(h), next_corner(corner_of(h))), kNone);
    if (!moved.find_neighbours()) return false;
  }
  const std::uint32_t a = faces[face_of(ring[0])].vertex[corner_of(ring[0])];
  std::array<Halfedge, Triangulation::kCrowd> at_a{};
  std::array<Halfedge, Triangulation::kCrowd> at_b{};
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::uint32_t f = face_of(ring[i]);
    const std::uint32_t g = new_faces + static_cast<std::uint32_t>(i);
    const std::uint32_t x = corner_of(ring[i]);
    const std::uint32_t y = next_corner(x);
    const std::uint32_t z = previous_corner(x);
    const SquaredSides sides = lengths.squared(f, faces[f]);
    faces[g] = faces[f];
    MovedSides<1> moved(faces);
    moved.add(halfedge(f, y), halfedge(g, y));
    (void)moved.find_neighbours();
    moved.join();
    faces[f].vertex[y] = v;
    faces[g].vertex[x] = v;
    join(faces, halfedge(f, y), halfedge(g, z));
    const DoubleDouble half2 = sides[x] * 0.25;
    const DoubleDouble across2 = (sides[y] + sides[z]) * 0.5 - half2;
    SquaredSides left = sides;
    SquaredSides right = sides;
    left[x] = right[x] = half2;
    left[y] = right[z] = across2;
    set_shape(faces[f], left);
    set_shape(faces[g], right);
    lengths.set(f, left);
    lengths.set(g, right);
    const bool is_along = faces[f].vertex[x] == a;
    at_a[i] = halfedge(is_along ? f : g, x);
    at_b[i] = halfedge(is_along ? g : f, x);
  }
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::size_t next = i + 1 < ring.size() ? i + 1 : 0;
    faces[face_of(at_a[i])].ring[corner_of(at_a[i])] = at_a[next];
    faces[face_of(at_b[i])].ring[corner_of(at_b[i])] = at_b[next];
  }
  return true;
}

}  // namespace geodesic
