#include "core/mesh/weld.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <vector>

#include "core/base/polled_sort.h"
#include "core/mesh/mesh.h"

namespace geodesic {
namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

// A cube of a grid whose cells are two tolerances wide, by whole numbers kept as
// doubles. Where these are too large to be told apart, so are the coordinates.
struct Cell {
  double x;
  double y;
  double z;
  // NOLINTNEXTLINE(modernize-use-nullptr): it takes what compares the parts for 0
  friend auto operator<=>(const Cell&, const Cell&) = default;
};

// Those that stayed, by cell: a sorted list of all cells that any vertex is in, and
// for each a chain. In a cell of two tolerances there is room for few that are a
// tolerance apart, so chains are short.
class Stayed {
 public:
  // Of no use if the poll says to stop.
  Stayed(const std::vector<Vec3>& positions, double width, Poll& poll) : width_(width) {
    cells_.reserve(positions.size());
    for (const Vec3& p : positions) cells_.push_back(cell_of(p));
    std::vector<Cell> spare;
    polled_sort(cells_, 0, cells_.size(), is_before, spare, poll);
    if (poll.stopped()) return;
    cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
    first_.assign(cells_.size(), kNobody);
    next_.resize(positions.size());
  }

  void add(std::uint32_t vertex, Vec3 p) {
    std::uint32_t& first = first_[find(cell_of(p))];
    next_[vertex] = first;
    first = vertex;
  }

  // The nearest one at most half a cell's width away, or kNobody.
  [[nodiscard]] std::uint32_t nearest(const std::vector<Vec3>& positions, Vec3 p) const {
    // Half a cell's width reaches into one neighbour a direction.
    const Cell low{std::floor(p.x / width_ - 0.5), std::floor(p.y / width_ - 0.5),
                   std::floor(p.z / width_ - 0.5)};
    std::uint32_t best = kNobody;
    double best_distance = width_ / 2;
    for (int k = 0; k < 8; ++k) {
      const Cell cell{low.x + (k & 1), low.y + (k >> 1 & 1), low.z + (k >> 2)};
      const std::size_t at = find(cell);
      if (at == cells_.size()) continue;
      for (std::uint32_t v = first_[at]; v != kNobody; v = next_[v]) {
        const double d = distance(positions[v], p);
        if (d > best_distance || (d == best_distance && v >= best)) continue;
        best = v;
        best_distance = d;
      }
    }
    return best;
  }

 private:
  static bool is_before(const Cell& a, const Cell& b) { return std::is_lt(a <=> b); }
  [[nodiscard]] Cell cell_of(Vec3 p) const {
    return {std::floor(p.x / width_), std::floor(p.y / width_), std::floor(p.z / width_)};
  }
  // Its place, or the end when no vertex is in it.
  [[nodiscard]] std::size_t find(const Cell& cell) const {
    const auto it = std::lower_bound(cells_.begin(), cells_.end(), cell, is_before);
    if (it == cells_.end() || !(*it == cell)) return cells_.size();
    return static_cast<std::size_t>(it - cells_.begin());
  }

  double width_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> first_;  // of a cell's chain
  std::vector<std::uint32_t> next_;   // of a vertex in its chain
};

}  // namespace

Result<std::uint64_t> weld_within(TriangleSoup& soup, double tolerance, const Cancel& cancel) {
  // `Mesh::build` refuses these, and the grid has no cells for them.
  const auto is_usable = [](const Vec3& p) {
    // Written so that NaN fails it, in whichever coordinate.
    return std::abs(p.x) <= Mesh::kMaxCoordinate && std::abs(p.y) <= Mesh::kMaxCoordinate &&
           std::abs(p.z) <= Mesh::kMaxCoordinate;
  };
  if (!std::all_of(soup.positions.begin(), soup.positions.end(), is_usable)) return 0;
  Poll poll(cancel);
  Stayed stayed(soup.positions, 2 * tolerance, poll);
  std::uint64_t moved = 0;
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    if (poll.stopped() || poll.cancelled(i, soup.positions.size())) {
      return fail(ErrorCode::cancelled, "welding was told to stop");
    }
    Vec3& p = soup.positions[i];
    const std::uint32_t other = stayed.nearest(soup.positions, p);
    if (other == kNobody) {
      stayed.add(static_cast<std::uint32_t>(i), p);
    } else if (!(p == soup.positions[other])) {
      p = soup.positions[other];
      ++moved;
    }
  }
  return moved;
}

}  // namespace geodesic
