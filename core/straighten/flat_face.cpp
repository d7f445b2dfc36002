#include "core/straighten/flat_face.h"

#include <algorithm>

#include "core/base/tolerances.h"

namespace geodesic {
namespace {

// Caps that follow each other from side to side. A surface has few.
constexpr int kMostCaps = 64;

Vec3 unit_or_zero(Vec3 v) {
  const double size = norm(v);
  return size > 0 ? (1 / size) * v : Vec3{};
}

Vec3 along_base(const Mesh& mesh, const FlatFace& flat) {
  const Triangle& t = mesh.faces()[flat.face];
  return (1 / flat.over.length) *
         (mesh.positions()[t[flat.corner(1)]] - mesh.positions()[t[flat.corner(0)]]);
}

// From the base to the apex, at a right angle to the base.
Vec3 own_inward(const Mesh& mesh, const FlatFace& flat) {
  const Triangle& t = mesh.faces()[flat.face];
  const Vec3 to_apex = mesh.positions()[t[flat.corner(2)]] - mesh.positions()[t[flat.corner(0)]];
  return unit_or_zero(to_apex - flat.over.apex_from_tail.x * along_base(mesh, flat));
}

// What is across a side, if that is one face.
Halfedge across(const Adjacency& adjacency, Halfedge side) {
  const Halfedge in = adjacency.ring(side);
  return in != side && adjacency.ring(in) == side ? in : kNone;
}

// Of the sides of a cap, in the order in which to look for a plane: that under the cap, to which a
// straight line goes on from its corner; then the longer of the other two.
std::array<std::uint32_t, 3> sides_of_cap(const FlatFace& flat, std::uint32_t under) {
  const double lengths[3] = {flat.over.length, norm(flat.over.apex_from_head),
                             norm(flat.over.apex_from_tail)};
  std::array<std::uint32_t, 3> sides{under, next_corner(under), previous_corner(under)};
  if (lengths[sides[2]] > lengths[sides[1]]) std::swap(sides[1], sides[2]);
  return sides;
}

// Which way is into the cap over the side under it, by what is across one of its sides; zero if
// nothing there says so.
Vec3 above_cap(const Adjacency& adjacency, const FlatFace& cap, std::uint32_t first_side) {
  const Mesh& mesh = adjacency.mesh();
  Halfedge leaves = cap.side(first_side);
  double sense = first_side == cap.side_under_cap() ? 1 : -1;
  for (int caps = 0; caps < kMostCaps; ++caps) {
    const Halfedge enters = across(adjacency, leaves);
    if (enters == kNone) return {};
    const FlatFace flat(mesh, enters);
    const std::uint32_t under = flat.side_under_cap();
    // Into one face is out of the other.
    if (under == kNone) return -sense * own_inward(mesh, flat);
    const auto sides = sides_of_cap(flat, under);
    // Into it over the side under it is out of it over the others.
    const std::uint32_t leaves_by = sides[0] == 0 ? sides[1] : sides[0];
    const bool turns = (under == 0) != (leaves_by == under);
    sense = turns ? sense : -sense;
    leaves = flat.side(leaves_by);
  }
  return {};
}

}  // namespace

std::uint32_t FlatFace::side_under_cap() const {
  const double lengths[3] = {over.length, norm(over.apex_from_head), norm(over.apex_from_tail)};
  const auto longest = static_cast<std::uint32_t>(std::max_element(lengths, lengths + 3) - lengths);
  const double shortest = *std::min_element(lengths, lengths + 3);
  // Of the corner opposite. A needle's is next to another one, and its plane is as good as any.
  const double height = over.apex_from_tail.y * over.length / lengths[longest];
  return height <= tolerance::kZeroArea * lengths[longest] &&
                 height <= tolerance::kLeastSide * shortest
             ? longest
             : kNone;
}

std::pair<Vec3, Vec3> FlatFace::axes(const Adjacency& adjacency) const {
  const Mesh& mesh = adjacency.mesh();
  const Vec3 along = along_base(mesh, *this);
  const std::uint32_t under = side_under_cap();
  if (under == kNone) return {along, own_inward(mesh, *this)};
  for (const std::uint32_t side : sides_of_cap(*this, under)) {
    const Vec3 above = above_cap(adjacency, *this, side);
    if (above == Vec3{}) continue;
    const Vec3 inward = under == 0 ? above : -1 * above;
    return {along, unit_or_zero(inward - dot(inward, along) * along)};
  }
  return {along, own_inward(mesh, *this)};
}

}  // namespace geodesic
