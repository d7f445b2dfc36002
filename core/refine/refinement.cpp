#include "core/refine/refinement.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace geodesic {
namespace {

double area2_of(const Weights& a, const Weights& b, const Weights& c) {
  return (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
}

}  // namespace

Refinement::Refinement(std::vector<FacePiece> pieces) : pieces_(std::move(pieces)) {
  std::sort(pieces_.begin(), pieces_.end(),
            [](const FacePiece& a, const FacePiece& b) { return a.face < b.face; });
  by_parent_.resize(pieces_.size());
  std::iota(by_parent_.begin(), by_parent_.end(), 0U);
  std::sort(by_parent_.begin(), by_parent_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(pieces_[a].parent, a) < std::tie(pieces_[b].parent, b);
  });
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

std::optional<FacePlace> Refinement::in_piece(std::uint32_t source_face,
                                              const Weights& bary) const {
  // What rounding may leave of a point on a border.
  constexpr double kOutside = -1e-9;
  const auto [first, last] = parts_of(source_face);
  std::optional<FacePlace> best;
  double deepest = kOutside;
  for (std::size_t i = first; i < last; ++i) {
    const FacePiece& part = pieces_[by_parent_[i]];
    const auto& [a, b, c] = part.corners;
    const double all = area2_of(a, b, c);
    if (!(all > 0)) continue;
    Weights inside{area2_of(bary, b, c) / all, area2_of(a, bary, c) / all,
                   area2_of(a, b, bary) / all};
    const double least = std::min({inside[0], inside[1], inside[2]});
    if (least <= deepest) continue;
    for (double& weight : inside) {
      if (weight < kSnap) weight = 0;
    }
    best = {part.face, inside};
    if (least >= 0) break;
    deepest = least;
  }
  return best;
}

}  // namespace geodesic
