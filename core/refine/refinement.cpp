#include "core/refine/refinement.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "core/mesh/mesh.h"

namespace geodesic {
namespace {

double area2_of(const Weights& a, const Weights& b, const Weights& c) {
  return (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
}

// What rounding may leave of a point on a border between parts.
constexpr double kOutsidePart = -1e-9;
// How far beside parts a point is looked for in them, of their parent's sides: more than that is.
constexpr double kBesidePart = 1e-6;

// The root of the tree that is kept in a range.
std::size_t middle_of(std::size_t first, std::size_t last) { return first + (last - first) / 2; }

}  // namespace

Refinement::Refinement(std::vector<FacePiece> pieces) : pieces_(std::move(pieces)) {
  std::sort(pieces_.begin(), pieces_.end(),
            [](const FacePiece& a, const FacePiece& b) { return a.face < b.face; });
  by_parent_.resize(pieces_.size());
  std::iota(by_parent_.begin(), by_parent_.end(), 0U);
  std::sort(by_parent_.begin(), by_parent_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(pieces_[a].parent, a) < std::tie(pieces_[b].parent, b);
  });
  extents_.resize(pieces_.size());
  for (std::size_t first = 0; first < by_parent_.size();) {
    const std::uint32_t parent = pieces_[by_parent_[first]].parent;
    std::size_t last = first + 1;
    while (last < by_parent_.size() && pieces_[by_parent_[last]].parent == parent) ++last;
    make_tree(first, last);
    first = last;
  }
}

void Refinement::make_tree(std::size_t first, std::size_t last) {
  if (first == last) return;
  Extent whole{};
  for (std::size_t k = 0; k < 2; ++k) {
    whole.low[k] = whole.high[k] = pieces_[by_parent_[first]].corners[0][k + 1];
    for (std::size_t i = first; i < last; ++i) {
      for (const Weights& corner : pieces_[by_parent_[i]].corners) {
        whole.low[k] = std::min(whole.low[k], corner[k + 1]);
        whole.high[k] = std::max(whole.high[k], corner[k + 1]);
      }
    }
  }
  const std::size_t wider = whole.high[1] - whole.low[1] > whole.high[0] - whole.low[0] ? 1 : 0;
  const auto centre = [&](std::uint32_t piece) {  // three times it
    const auto& [a, b, c] = pieces_[piece].corners;
    return a[wider + 1] + b[wider + 1] + c[wider + 1];
  };
  const std::size_t middle = middle_of(first, last);
  const auto at = [&](std::size_t i) {
    return by_parent_.begin() + static_cast<std::ptrdiff_t>(i);
  };
  std::nth_element(at(first), at(middle), at(last),
                   [&](std::uint32_t a, std::uint32_t b) { return centre(a) < centre(b); });
  extents_[middle] = whole;
  make_tree(first, middle);
  make_tree(middle + 1, last);
}

const FacePiece* Refinement::piece(std::uint32_t face) const {
  const auto at =
      std::lower_bound(pieces_.begin(), pieces_.end(), face,
                       [](const FacePiece& piece, std::uint32_t f) { return piece.face < f; });
  return at == pieces_.end() || at->face != face ? nullptr : &*at;
}

std::pair<std::size_t, std::size_t> Refinement::parts_of(std::uint32_t source_face) const {
  const auto first = std::lower_bound(
      by_parent_.begin(), by_parent_.end(), source_face,
      [&](std::uint32_t place, std::uint32_t parent) { return pieces_[place].parent < parent; });
  const auto last = std::upper_bound(
      first, by_parent_.end(), source_face,
      [&](std::uint32_t parent, std::uint32_t place) { return parent < pieces_[place].parent; });
  return {first - by_parent_.begin(), last - by_parent_.begin()};
}

bool Refinement::is_split(std::uint32_t source_face) const {
  const auto [first, last] = parts_of(source_face);
  return first != last;
}

std::optional<Weights> Refinement::in_parent(std::uint32_t face, const Weights& bary) const {
  const FacePiece* part = piece(face);
  if (part == nullptr) return std::nullopt;
  Weights weights{0, 0, 0};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) weights[k] += bary[c] * part->corners[c][k];
  }
  const double sum = weights[0] + weights[1] + weights[2];
  for (double& weight : weights) weight /= sum;
  return weights;
}

template <class Visit>
void Refinement::each_about(std::size_t first, std::size_t last, const Weights& bary, Poll& poll,
                            const Visit& visit) const {
  if (first == last || poll.cancelled()) return;
  const std::size_t middle = middle_of(first, last);
  const Extent& extent = extents_[middle];
  for (std::size_t k = 0; k < 2; ++k) {
    if (bary[k + 1] < extent.low[k] - kBesidePart) return;
    if (bary[k + 1] > extent.high[k] + kBesidePart) return;
  }
  visit(by_parent_[middle]);
  each_about(first, middle, bary, poll, visit);
  each_about(middle + 1, last, bary, poll, visit);
}

std::optional<FacePlace> Refinement::in_piece(std::uint32_t source_face, const Weights& bary,
                                              Poll& poll) const {
  const auto [first, last] = parts_of(source_face);
  std::uint32_t best = kNone;
  double deepest = kOutsidePart;
  Weights there{};
  each_about(first, last, bary, poll, [&](std::uint32_t i) {
    const auto& [a, b, c] = pieces_[i].corners;
    const double all = area2_of(a, b, c);
    if (!(all > 0)) return;
    const Weights inside{area2_of(bary, b, c) / all, area2_of(a, bary, c) / all,
                         area2_of(a, b, bary) / all};
    // Inside two parts, on their border, it is in the one of the lesser number.
    const double depth = std::min({inside[0], inside[1], inside[2], 0.0});
    const bool is_deeper = depth > deepest;
    const bool is_before = depth == deepest && best != kNone && i < best;
    if (!is_deeper && !is_before) return;
    best = i;
    deepest = depth;
    there = inside;
  });
  if (best == kNone) return std::nullopt;
  for (double& weight : there) {
    if (weight < kSnap) weight = 0;
  }
  return FacePlace{pieces_[best].face, there};
}

}  // namespace geodesic
