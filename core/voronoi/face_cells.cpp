#include "core/voronoi/face_cells.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "core/base/double_double.h"
#include "core/base/tolerances.h"

namespace geodesic {
namespace {

using Weights3 = std::array<double, 3>;

// Determinants decide which cells there are, and two cells must not have the same place: so they
// are computed in twice the digits that distances have.
using Terms = std::array<DoubleDouble, 3>;

DoubleDouble exact_difference(double a, double b) { return DoubleDouble::sum(a, -b); }
Terms difference(const Weights3& a, const Weights3& b) {
  return {exact_difference(a[0], b[0]), exact_difference(a[1], b[1]), exact_difference(a[2], b[2])};
}
Terms cross_of(const Terms& a, const Terms& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
DoubleDouble dot_of(const Terms& a, const Terms& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
DoubleDouble sum_of(const Terms& a) { return a[0] + a[1] + a[2]; }

// Nothing where it is no more than what rounding may have left of products of this size, whose
// exact sum is zero: sites that are as far from both ends of an edge meet nowhere else.
DoubleDouble without_rounding(const DoubleDouble& value, double size) {
  return std::abs(value.high) <= tolerance::kDoubleDouble * size ? DoubleDouble() : value;
}
// The sum of a cross product's terms.
DoubleDouble sum_of_cross(const Terms& a, const Terms& b) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (i != k) size += std::abs(a[i].high * b[k].high);
    }
  }
  return without_rounding(sum_of(cross_of(a, b)), size);
}
// The determinant of three rows.
DoubleDouble determinant(const Terms& a, const Terms& b, const Terms& c) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t k = (i + 1) % 3;
    const std::size_t l = (i + 2) % 3;
    size +=
        std::abs(a[i].high) * (std::abs(b[k].high * c[l].high) + std::abs(b[l].high * c[k].high));
  }
  return without_rounding(dot_of(a, cross_of(b, c)), size);
}

// Sorts pointers to candidates by their sites; whether that takes an odd number of swaps.
template <class Pointers>
bool sort_by_site(Pointers& candidates) {
  bool is_odd = false;
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    for (std::size_t k = i; k > 0 && candidates[k]->site < candidates[k - 1]->site; --k) {
      std::swap(candidates[k], candidates[k - 1]);
      is_odd = !is_odd;
    }
  }
  return is_odd;
}

// The sign of a determinant under Simulation of Simplicity (Edelsbrunner, Mücke 1990): of its value
// and of the coefficients of ever smaller lengths, the first that is not zero.
double perturbed_sign(std::initializer_list<DoubleDouble> terms) {
  for (const DoubleDouble& term : terms) {
    if (term.high != 0) return term.high;
  }
  return 0;
}

// The sign of the determinant with the rows (1, g(a), g(b)) of three candidates. g is a candidate's
// squared distance, a and b are corners of the face.
template <class Three>
double along_edge(Three sites, const std::array<std::uint32_t, 2>& ends) {
  const bool is_odd = sort_by_site(sites);
  const auto rise = [&](std::size_t i, std::size_t end) {
    return exact_difference(sites[i]->square[ends[end]], sites[0]->square[ends[end]]);
  };
  const DoubleDouble of_last = rise(1, 0) - rise(1, 1);
  const DoubleDouble of_second = rise(2, 1) - rise(2, 0);
  const DoubleDouble one = rise(1, 0) * rise(2, 1);
  const DoubleDouble other = rise(1, 1) * rise(2, 0);
  const DoubleDouble value =
      without_rounding(one - other, std::abs(one.high) + std::abs(other.high));
  const double sign = perturbed_sign({value, of_last, of_second, -of_last - of_second});
  return is_odd ? -sign : sign;
}

// The same of four candidates with the rows (1, g(a), g(b), g(c)).
template <class Four>
double in_face(Four sites) {
  const bool is_odd = sort_by_site(sites);
  const Terms u = difference(sites[1]->square, sites[0]->square);
  const Terms v = difference(sites[2]->square, sites[0]->square);
  const Terms w = difference(sites[3]->square, sites[0]->square);
  const DoubleDouble of_last = sum_of_cross(u, v);
  const DoubleDouble of_third = sum_of_cross(w, u);
  const DoubleDouble of_second = sum_of_cross(v, w);
  const double sign = perturbed_sign(
      {determinant(u, v, w), of_last, of_third, of_second, -of_last - of_third - of_second});
  return is_odd ? -sign : sign;
}

// How three functions turn round the place where they are the same.
template <class Three>
double turn_of(Three sites) {
  const bool is_odd = sort_by_site(sites);
  const double turn = sum_of_cross(difference(sites[1]->square, sites[0]->square),
                                   difference(sites[2]->square, sites[0]->square))
                          .high;
  return is_odd ? -turn : turn;
}

// Where three functions are the same, whatever their order.
template <class Three>
Weights3 meeting_of(Three sites) {
  (void)sort_by_site(sites);
  const Terms u = difference(sites[1]->square, sites[0]->square);
  const Terms v = difference(sites[2]->square, sites[0]->square);
  // Where two functions are the same as a third, times what the weights add up to.
  const Terms at = cross_of(u, v);
  const DoubleDouble sum = sum_of_cross(u, v);
  if (sum.high == 0) return {1.0 / 3, 1.0 / 3, 1.0 / 3};  // nowhere: they never are asked for
  Weights3 weights{};
  double inside = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    weights[c] = std::clamp((at[c] / sum).high, 0.0, 1.0);
    inside += weights[c];
  }
  for (double& weight : weights) weight /= inside;
  return weights;
}

}  // namespace

Vec3 position_in_face(const Adjacency& adjacency, std::uint32_t face,
                      const std::array<double, 3>& weights) {
  // From the corner that it is nearest to in numbers, and in the order of the vertices.
  const auto& vertex = adjacency.face(face).vertex;
  const auto positions = adjacency.mesh().positions();
  std::array<std::uint32_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return vertex[a] < vertex[b]; });
  std::uint32_t base = order[0];
  for (const std::uint32_t c : order) {
    if (weights[c] > weights[base]) base = c;
  }
  Vec3 sum = positions[vertex[base]];
  for (const std::uint32_t c : order) {
    if (c == base || weights[c] == 0) continue;
    sum = sum + weights[c] * (positions[vertex[c]] - positions[vertex[base]]);
  }
  return sum;
}

std::uint32_t border_site(const Adjacency& adjacency, const NearSites& near, Halfedge h) {
  if (const std::uint32_t owner = near.owner(face_of(h)); owner != kNone) return owner;
  const auto at_head = near.of(adjacency.head(h));
  for (const NearSite& site : near.of(adjacency.tail(h))) {
    if (site.square != 0) continue;
    const auto other = std::find_if(at_head.begin(), at_head.end(), [&](const NearSite& entry) {
      return entry.site == site.site && entry.square == 0;
    });
    if (other != at_head.end()) return site.site;
  }
  return kNone;
}

double CellPart::share() const {
  double sum = 0;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const auto& a = corners[0];
    const auto& b = corners[i - 1];
    const auto& c = corners[i];
    sum += (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
  }
  return std::max(sum, 0.0);
}

std::array<std::uint32_t, 2> FaceCells::ends_of(std::uint32_t side) const {
  const std::uint32_t next = next_corner(side);
  return face_->vertex[side] < face_->vertex[next] ? std::array{side, next}
                                                   : std::array{next, side};
}

const FaceCells::Candidate& FaceCells::candidate(std::uint32_t site) const {
  return *std::lower_bound(
      candidates_.begin(), candidates_.end(), site,
      [](const Candidate& entry, std::uint32_t number) { return entry.site < number; });
}

double FaceCells::turn(const std::array<std::uint32_t, 3>& sites) const {
  return turn_of(Three{&candidate(sites[0]), &candidate(sites[1]), &candidate(sites[2])});
}

void FaceCells::find_candidates(const FaceRecord& face) {
  candidates_.clear();
  std::array<std::span<const NearSite>, 3> near;
  for (std::size_t c = 0; c < 3; ++c) near[c] = near_.of(face.vertex[c]);
  while (true) {
    std::uint32_t least = kNone;
    for (const auto& rest : near) {
      if (!rest.empty()) least = std::min(least, rest.front().site);
    }
    if (least == kNone) return;
    Candidate next{least, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      next.square[c] = near_.square(face.vertex[c], least);
      if (!near[c].empty() && near[c].front().site == least) near[c] = near[c].subspan(1);
    }
    candidates_.push_back(next);
  }
}

// Without those that another is nearer than at all three corners. All that are left differ by
// functions that are zero somewhere in the face, and no two are the same.
void FaceCells::drop_hidden(Poll& poll) {
  const auto is_nearer = [](const Candidate& a, const Candidate& b, std::size_t c) {
    return a.square[c] < b.square[c] || (a.square[c] == b.square[c] && a.site < b.site);
  };
  kept_.clear();
  for (const Candidate& one : candidates_) {
    if (poll.cancelled_after(candidates_.size())) return;
    const bool is_hidden =
        std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& other) {
          return is_nearer(other, one, 0) && is_nearer(other, one, 1) && is_nearer(other, one, 2);
        });
    if (!is_hidden) kept_.push_back(one);
  }
  std::swap(candidates_, kept_);
}

// Of the corner before side `corner`: whether `by` is nearer there than the part's own site.
bool FaceCells::is_cut_off(const CellPart& part, std::size_t corner, const Candidate& own,
                           const Candidate& by) const {
  const std::size_t count = part.sides.size();
  CellSide one = part.sides[(corner + count - 1) % count];
  CellSide other = part.sides[corner];
  if (one.is_of_face() && other.is_of_face()) {
    const std::uint32_t c = other.corner();
    return by.square[c] < own.square[c] || (by.square[c] == own.square[c] && by.site < own.site);
  }
  if (!one.is_of_face() && !other.is_of_face()) {
    const Candidate& first = candidate(one.site());
    const Candidate& second = candidate(other.site());
    const double turn = turn_of(Three{&own, &first, &second});
    const double sign = in_face(std::array<const Candidate*, 4>{&own, &first, &second, &by});
    return turn > 0 ? sign < 0 : turn < 0 && sign > 0;
  }
  if (one.is_of_face()) std::swap(one, other);
  const Candidate& against = candidate(one.site());
  const auto ends = ends_of(other.corner());
  const double at_low = against.square[ends[0]] - own.square[ends[0]];
  const bool is_own_at_low = at_low > 0 || (at_low == 0 && own.site < against.site);
  const double sign = along_edge(Three{&own, &against, &by}, ends);
  return is_own_at_low ? sign < 0 : sign > 0;
}

bool FaceCells::cut(CellPart& part, const Candidate& own, const Candidate& by) {
  const std::size_t count = part.sides.size();
  is_cut_off_.resize(count);
  std::size_t begins = 0;
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    is_cut_off_[i] = is_cut_off(part, i, own, by) ? 1 : 0;
    any = any || is_cut_off_[i] != 0;
  }
  if (!any) return true;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_cut_off_[i] == 0 && is_cut_off_[(i + 1) % count] != 0) ++begins;
  }
  if (begins == 0) return false;
  // What is cut off hangs together; where rounding says otherwise, it is next to nothing.
  if (begins > 1) return true;
  rest_.sides.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const bool from = is_cut_off_[i] != 0;
    const bool to = is_cut_off_[(i + 1) % count] != 0;
    if (!from || !to) rest_.sides.push_back(part.sides[i]);
    if (!from && to) rest_.sides.push_back(CellSide::against(by.site));
  }
  std::swap(part.sides, rest_.sides);
  return true;
}

std::array<double, 3> FaceCells::place(const CellPart& part, std::size_t corner,
                                       const Candidate& own) const {
  const std::size_t count = part.sides.size();
  CellSide one = part.sides[(corner + count - 1) % count];
  CellSide other = part.sides[corner];
  Weights3 weights{0, 0, 0};
  if (one.is_of_face() && other.is_of_face()) {
    weights[other.corner()] = 1;
    return weights;
  }
  if (!one.is_of_face() && !other.is_of_face()) {
    return meeting_of(Three{&own, &candidate(one.site()), &candidate(other.site())});
  }
  if (one.is_of_face()) std::swap(one, other);
  const Candidate& against = candidate(one.site());
  const auto [low, high] = ends_of(other.corner());
  const double at_low = against.square[low] - own.square[low];
  const double at_high = against.square[high] - own.square[high];
  // Both are zero where two sites are as far from all of the edge.
  const double part_way = at_low == at_high ? 0 : at_low / (at_low - at_high);
  weights[high] = std::clamp(part_way, 0.0, 1.0);
  weights[low] = 1 - weights[high];
  return weights;
}

std::span<const CellPart> FaceCells::parts_of(std::uint32_t f, Poll& poll) {
  count_ = 0;
  face_ = &adjacency_.face(f);
  for (const std::uint32_t v : face_->vertex) {
    if (!near_.is_reached(v)) return {};
  }
  if (const std::uint32_t owner = near_.owner(f); owner != kNone) {
    if (parts_.empty()) parts_.emplace_back();
    parts_[0] = {owner,
                 {CellSide::of_face(0), CellSide::of_face(1), CellSide::of_face(2)},
                 {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    count_ = 1;
    return {parts_.data(), count_};
  }
  find_candidates(*face_);
  if (candidates_.size() > 1) drop_hidden(poll);
  for (const Candidate& own : candidates_) {
    if (parts_.size() == count_) parts_.emplace_back();
    CellPart& part = parts_[count_];
    part.site = own.site;
    part.sides = {CellSide::of_face(0), CellSide::of_face(1), CellSide::of_face(2)};
    part.corners.clear();
    bool is_left = true;
    for (const Candidate& by : candidates_) {
      if (by.site == own.site) continue;
      if (poll.cancelled_after(part.sides.size())) return {};
      is_left = cut(part, own, by);
      if (!is_left) break;
    }
    if (!is_left) continue;
    for (std::size_t i = 0; i < part.sides.size(); ++i) part.corners.push_back(place(part, i, own));
    ++count_;
  }
  return {parts_.data(), count_};
}

}  // namespace geodesic
