#include "core/straighten/tighten_loop.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/tolerances.h"
#include "core/straighten/loop_slide.h"
#include "core/straighten/loop_straightness.h"
#include "core/straighten/path_chain.h"
#include "core/straighten/shorten_path.h"
#include "core/straighten/vertex_fan.h"

namespace geodesic {
namespace {

// Of its first length: a loop that is shorter goes round a point.
constexpr double kContracted = 1e-12;
// Bases in a row, at different places round the loop, that may gain nothing.
constexpr std::uint64_t kMostIdle = 8;

// The parts of 1: 1/2, 1/4, 3/4, 1/8, 5/8 … (van der Corput).
double part_of_one(std::uint64_t i) {
  double part = 0;
  double bit = 0.5;
  for (++i; i > 0; i /= 2, bit /= 2) part += static_cast<double>(i % 2) * bit;
  return part;
}

bool is_inside_face(const SurfacePoint& point) {
  return !point.at_vertex() && edge_under(point) == kNone;
}

class Tightener {
 public:
  Tightener(const Adjacency& adjacency, Path loop, const Cancel& cancel)
      : adjacency_(adjacency),
        cancel_(cancel),
        poll_(cancel),
        fans_(adjacency, poll_),
        path_(std::move(loop)),
        contracted_(kContracted * path_.length) {}

  Result<TightLoop> tighten() {
    // A point inside a face would hold the loop there for one base more.
    std::size_t first = 0;
    while (first + 1 < path_.points.size() && is_inside_face(path_.points[first].point)) ++first;
    if (first + 1 >= path_.points.size()) return contracts();
    cut_at(first);
    std::uint64_t idle = 0;
    double before = path_.length;
    while (true) {
      ShortenCounts counts;
      auto shorter = shorten_path(adjacency_, path_, cancel_, &counts);
      if (!shorter) return fail(std::move(shorter.error()));
      path_ = std::move(*shorter);
      faces_unfolded_ += counts.faces_unfolded;
      if (!(path_.length > contracted_)) return contracts();
      const auto chain = read_chain(adjacency_, path_, poll_);
      if (poll_.stopped()) return fail_stopped(poll_);
      if (!chain) return finished(false);
      if (is_straight_at_base(*chain)) {
        // Round pinched vertices and among needles, one shortening may leave something over.
        const auto straightness = straightness_of_loop(adjacency_, path_, cancel_);
        if (!straightness) return fail(straightness.error());
        if (!straightness->is_known) return finished(false);
        if (straightness->lack <= kMostLack) return finished(true);
      }
      if (poll_.stopped()) return fail_stopped(poll_);
      if (bases_ >= kMostBases || faces_unfolded_ > kMostFacesUnfolded) return finished(false);
      if (const auto slid = slide(*chain)) {
        if (!(path_.length > contracted_)) return contracts();
        if (*slid == kNone) return finished(true);
        if (cut_at_vertex(*slid) && path_.length < before * (1 - tolerance::kLeastGain)) {
          before = path_.length;
          continue;
        }
      }
      idle = path_.length < before * (1 - tolerance::kLeastGain) ? 0 : idle + 1;
      if (idle > kMostIdle) return finished(true);
      before = path_.length;
      cut_near(part_of_one(idle));
      if (poll_.ask()) return fail_stopped(poll_);
    }
  }

 private:
  [[nodiscard]] static tl::unexpected<Error> contracts() {
    return fail(ErrorCode::no_loop,
                "the loop contracts to a point: it goes round nothing that holds it");
  }

  Result<TightLoop> finished(bool is_finished) {
    return TightLoop{std::move(path_), bases_, is_finished};
  }

  // Makes that point the first one and the last.
  void cut_at(std::size_t place) {
    ++bases_;
    auto& points = path_.points;
    points.pop_back();
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(place), points.end());
    points.push_back(points.front());
  }

  // Whether the loop runs through it.
  [[nodiscard]] bool cut_at_vertex(std::uint32_t vertex) {
    for (std::size_t i = 0; i + 1 < path_.points.size(); ++i) {
      if (path_.points[i].point.vertex != vertex) continue;
      cut_at(i);
      return true;
    }
    return false;
  }

  // At the point that is nearest to that part of the way round: a vertex, where there is one.
  void cut_near(double part) {
    std::optional<std::size_t> best;
    bool best_at_vertex = false;
    double best_off = 0;
    double way = 0;
    for (std::size_t i = 1; i + 1 < path_.points.size(); ++i) {
      way += distance(path_.points[i - 1].position, path_.points[i].position);
      const SurfacePoint& point = path_.points[i].point;
      if (is_inside_face(point)) continue;
      const double off = std::abs(way - part * path_.length);
      if (best && best_at_vertex && !point.at_vertex()) continue;
      if (best && best_at_vertex == point.at_vertex() && !(off < best_off)) continue;
      best = i;
      best_at_vertex = point.at_vertex();
      best_off = off;
    }
    if (best) cut_at(*best);
  }

  [[nodiscard]] bool is_straight_at_base(const Chain& chain) {
    const auto& points = path_.points;
    const SurfacePoint& base = points.front().point;
    if (base.at_vertex()) {
      const std::uint32_t arrives = chain.segments.back().arrives.face;
      const std::uint32_t leaves = chain.segments.front().leaves.face;
      if (arrives == kNone || leaves == kNone) return false;  // beside it, at the same place
      return !fans_.least(base.vertex, chain.segments.back().arrives, chain.segments.front().leaves,
                          std::numbers::pi - tolerance::kStraightAngle);
    }
    return turn_inside(adjacency_, points[points.size() - 2], points[0], points[1]) <=
           tolerance::kStraightAngle;
  }

  // The vertex that ended it, or kNone; nothing where there is no sliding, or no gain in it.
  std::optional<std::uint32_t> slide(const Chain& chain) {
    const SurfacePoint& base = path_.points.front().point;
    if (edge_under(base) == kNone) return std::nullopt;
    auto slid = slide_loop(adjacency_, path_, chain);
    faces_unfolded_ += 2 * path_.points.size();
    if (!slid || slid->path.length > path_.length * (1 + tolerance::kLeastGain)) {
      return std::nullopt;
    }
    path_ = std::move(slid->path);
    return slid->touches;
  }

  const Adjacency& adjacency_;
  const Cancel& cancel_;
  Poll poll_;
  FanSearch fans_;
  Path path_;
  double contracted_;
  std::uint64_t faces_unfolded_ = 0;
  std::uint64_t bases_ = 0;
};

}  // namespace

Result<TightLoop> tighten_loop(const Adjacency& adjacency, const Path& loop, const Cancel& cancel) {
  auto tight = Tightener(adjacency, loop, cancel).tighten();
  if (tight && tight->path.length > loop.length) tight->path = loop;
  return tight;
}

}  // namespace geodesic
