#include "core/back_traced/front.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/back_traced/arrive_lanes.h"
#include "core/base/sort_few.h"
#include "core/base/team.h"

namespace geodesic {
namespace {

// Where a mesh is much finer than elsewhere, a bucket holds more than one front's worth
// of vertices: those farther than the least by more than this part of their face's
// shortest side are left for another round, so many times.
constexpr double kEarly = 0.5;
constexpr int kMostRoundsInBucket = 256;

// A round of so few vertices is soon done, and others are not told.
constexpr std::size_t kFewTogether = 16;

}  // namespace

BackTracedFront::BackTracedFront(const Adjacency& adjacency, BackTrace::Rule rule,
                                 BackTracedScratch& scratch, std::span<double> distance,
                                 std::size_t domains, Poll& poll)
    : adjacency_(adjacency),
      rule_(rule),
      scratch_(scratch),
      distance_(distance),
      poll_(poll),
      surface_(adjacency.delaunay()) {
  // What is told of crowded edges depends on the order in which it is told.
  const std::size_t count = surface_.is_crowded ? 1 : domains;
  if (scratch.domains.size() < count) scratch.domains.resize(count);
  domains_ = std::span(scratch.domains).first(count);
  by_blocks_ = BlockDomains(distance.size(), count);
  for (FrontDomain& domain : domains_) {
    // A query that had no memory left may have left some.
    for (std::vector<FrontEstimate>& handed : domain.handed_to) handed.clear();
    domain.handed_to.resize(count);
    domain.late.clear();
  }
  accepted_ = distance_;
  if (count > 1) {
    scratch.distance.assign(distance.begin(), distance.end());
    accepted_ = scratch.distance;
  }
}

template <class Work>
void BackTracedFront::in_each_domain(Work work) {
  if (domains_.size() == 1) return work(domains_[0], poll_);
  if (is_small_) {
    for (FrontDomain& domain : domains_) work(domain, poll_);
    return;
  }
  run_parts(domains_.size(), poll_,
            [this, work](std::size_t number, Poll& poll) { work(domains_[number], poll); });
}

// Estimates and distances differ by at most the longest side between neighbours. So a vertex is
// accepted before all that are farther by more than twice that.
double BackTracedFront::lag() const { return 2 * std::sqrt(surface_.longest2); }

void BackTracedFront::see(std::uint32_t vertex, double straight) {
  if (!(straight < distance_[vertex])) return;
  distance_[vertex] = accepted_[vertex] = straight;
  if (surface_.is_crowded) scratch_.crowds.tell(surface_, vertex, straight);
  settle(domain_of(vertex), vertex, {straight, kNone, 0});
}

// Inlined by force: it is most of what spreading does.
__attribute__((always_inline)) inline void BackTracedFront::lower(FrontDomain& own,
                                                                  std::uint32_t vertex,
                                                                  const FrontEstimate& estimate) {
  const FrontVertex& known = scratch_.vertices[vertex];
  const double before = std::abs(known.estimate);
  if (!(estimate.distance < before + least_gain_)) return;
  if (known.base == kNone && before < kUnreached) [[unlikely]] {
    own.late.push_back({vertex, estimate});
    return;
  }
  settle(own, vertex, estimate);
}

__attribute__((always_inline)) inline void BackTracedFront::settle(FrontDomain& own,
                                                                   std::uint32_t vertex,
                                                                   const FrontEstimate& given) {
  const auto& [estimate, base, crossing] = given;
  FrontVertex& known = scratch_.vertices[vertex];
  const double before = std::abs(known.estimate);
  // Visible from the source, but for those that go on past it, it has its base all the same.
  if (known.base == kNone && base != kNone && before < kUnreached) {
    known.base = base;
    known.crossing = crossing;
  }
  if (known.is_accepted()) {
    // Within a bucket it may have been too early.
    if (!(estimate < before - least_gain_) || !own.waiting.is_now(before)) return;
    known = {estimate, base, crossing};
    own.waiting.push_back(vertex);
    return;
  }
  if (!(estimate < before)) {
    // Of two that are as far, the same one, whichever came first.
    if (estimate == before && std::tie(base, crossing) < std::tie(known.base, known.crossing)) {
      known = {estimate, base, crossing};
    }
    return;
  }
  known = {estimate, base, crossing};
  own.waiting.push(vertex, estimate, before);
}

// What comes next in the domain. Those that were accepted by lesser estimates leave.
void BackTracedFront::look_ahead(FrontDomain& domain) const {
  domain.next =
      domain.waiting.first([&](std::uint32_t v) { return !scratch_.vertices[v].is_accepted(); });
  domain.least = kUnreached;
  const std::span<const std::uint32_t> vertices = domain.waiting.vertices_of(domain.next);
  domain.waiting_next = vertices.size();
  for (const std::uint32_t v : vertices) {
    const FrontVertex& known = scratch_.vertices[v];
    domain.least = std::min(domain.least, known.estimate);
    __builtin_prefetch(&surface_.corner_begin[v]);
    if (known.base != kNone) __builtin_prefetch(&surface_.faces[face_of(known.base)]);
  }
}

bool BackTracedFront::accept_next(double last) {
  if (!has_looked_) {
    for (FrontDomain& domain : domains_) look_ahead(domain);
    has_looked_ = true;
  }
  for (;;) {
    std::uint64_t bucket = VertexBuckets::kNoBucket;
    double least = kUnreached;
    std::size_t count = 0;
    for (const FrontDomain& domain : domains_) {
      if (domain.next > bucket) continue;
      if (domain.next < bucket) {
        bucket = domain.next;
        least = kUnreached;
        count = 0;
      }
      least = std::min(least, domain.least);
      count += domain.waiting_next;
    }
    is_small_ = count < kFewTogether;
    if (bucket == VertexBuckets::kNoBucket) return false;
    if (last < kUnreached && domains_[0].waiting.is_beyond(bucket, last)) return false;
    if (least < kUnreached) {
      const bool may_leave = rounds_in_bucket_ < kMostRoundsInBucket;
      in_each_domain([this, bucket, least, may_leave](FrontDomain& domain, Poll& poll) {
        take_round(domain, bucket, least, may_leave);
        trace_round(domain, poll);
      });
      break;
    }
    // It was too far away to be looked at.
    for (FrontDomain& domain : domains_) {
      domain.waiting.go_to(bucket);
      look_ahead(domain);
    }
  }
  has_looked_ = false;
  const bool are_any_early =
      std::any_of(domains_.begin(), domains_.end(),
                  [](const FrontDomain& domain) { return domain.has_left_early; });
  rounds_in_bucket_ = are_any_early ? rounds_in_bucket_ + 1 : 0;
  // Of several, each does so when it spreads.
  if (domains_.size() == 1) accept_round(domains_[0]);
  return true;
}

// The vertices of the bucket, ascending, without those that are too early if these may be left.
void BackTracedFront::take_round(FrontDomain& domain, std::uint64_t bucket, double least,
                                 bool may_leave) {
  std::vector<std::uint32_t>& round = domain.round;
  round.clear();
  domain.accepted = 0;
  domain.has_left_early = false;
  domain.waiting.go_to(bucket);
  if (domain.next != bucket) return;
  domain.waiting.take_now(round);
  std::size_t count = 0;
  for (const std::uint32_t v : round) {
    if (may_leave && is_early(v, least)) {
      domain.waiting.push_back(v);
      continue;
    }
    round[count++] = v;
    __builtin_prefetch(surface_.corners(v).data());
  }
  domain.has_left_early = count < round.size();
  domain.accepted = count;
  round.resize(count);
  // What is near in number is near in memory.
  sort_few(round);
}

// Whether one of those to be accepted may yet have a say in the estimate of the vertex.
bool BackTracedFront::is_early(std::uint32_t vertex, double least) const {
  const FrontVertex& known = scratch_.vertices[vertex];
  if (known.base == kNone) return false;
  const double after = known.estimate - least;
  return after * after > kEarly * kEarly * surface_.faces[face_of(known.base)].shortest2();
}

void BackTracedFront::trace_round(FrontDomain& domain, Poll& poll) {
  domain.best.resize(domain.round.size());
  trace_back(state(distance_), domain.round, domain.best, domain.room, poll);
  if (domains_.size() == 1) return;
  for (std::size_t i = 0; i < domain.round.size(); ++i) {
    accepted_[domain.round[i]] = domain.best[i];
  }
}

// Only once all domains have traced, so that no result depends on which vertices were traced
// together.
void BackTracedFront::accept_round(FrontDomain& domain) {
  for (std::size_t i = 0; i < domain.round.size(); ++i) {
    const std::uint32_t v = domain.round[i];
    distance_[v] = domain.best[i];
    if (surface_.is_crowded) scratch_.crowds.tell(surface_, v, domain.best[i]);
    scratch_.vertices[v].estimate *= -1;
  }
}

std::size_t BackTracedFront::accepted_count() const {
  std::size_t count = 0;
  for (const FrontDomain& domain : domains_) count += domain.accepted;
  return count;
}

bool BackTracedFront::may_improve() const {
  return std::any_of(domains_.begin(), domains_.end(),
                     [](const FrontDomain& domain) { return domain.waiting.has_more_now(); });
}

void BackTracedFront::spread() {
  in_each_domain([this](FrontDomain& domain, Poll& poll) {
    if (domains_.size() > 1) accept_round(domain);
    give_estimates(domain, poll);
  });
  in_each_domain([this](FrontDomain& domain, Poll&) { take_estimates(domain); });
  has_looked_ = true;
}

// To the vertices of the domain itself at once.
void BackTracedFront::give_estimates(FrontDomain& domain, Poll& poll) {
  for (const std::uint32_t v : domain.round) {
    if (adjacency_.is_pinched(v)) spread_along_edges(domain, v);
  }
  const FrontState front = state(accepted_);
  FrontRoom& room = domain.room;
  const auto give = [&](std::size_t at, double distance, float crossing) {
    this->give(domain, {distance, room.bases[at], crossing});
  };
  arrive_over_bases(front, list_bases(front, domain.round, room), room, poll, give);
}

__attribute__((always_inline)) inline void BackTracedFront::give(FrontDomain& from,
                                                                 const FrontEstimate& estimate) {
  const std::uint32_t vertex = opposite(surface_, estimate.base);
  if (domains_.size() > 1) {
    const std::size_t number = by_blocks_.of(vertex);
    if (&domains_[number] != &from) {
      from.handed_to[number].push_back(estimate);
      return;
    }
  }
  lower(from, vertex, estimate);
}

// What others have for the vertices of the domain; and what had to wait until all was there.
void BackTracedFront::take_estimates(FrontDomain& domain) {
  const auto number = static_cast<std::size_t>(&domain - domains_.data());
  for (FrontDomain& other : domains_) {
    std::vector<FrontEstimate>& handed = other.handed_to[number];
    for (const FrontEstimate& estimate : handed) {
      lower(domain, opposite(surface_, estimate.base), estimate);
    }
    handed.clear();
  }
  std::vector<FrontDomain::Late>& late = domain.late;
  if (!late.empty()) {
    std::sort(late.begin(), late.end(), [](const auto& a, const auto& b) {
      return std::tie(a.vertex, a.estimate.distance, a.estimate.base, a.estimate.crossing) <
             std::tie(b.vertex, b.estimate.distance, b.estimate.base, b.estimate.crossing);
    });
    for (const auto& [vertex, estimate] : late) settle(domain, vertex, estimate);
    late.clear();
  }
  look_ahead(domain);
}

// Where faces meet in nothing but the vertex, no triangle beyond it has two accepted
// ones.
void BackTracedFront::spread_along_edges(FrontDomain& from, std::uint32_t v) {
  for (const std::uint32_t corner : surface_.corners(v)) {
    const FaceRecord& face = surface_.faces[face_of(corner)];
    const std::uint32_t c = corner_of(corner);
    for (const std::uint32_t side : {c, previous_corner(c)}) {
      const std::uint32_t w = side == c ? next_corner(c) : side;
      const std::uint32_t tail = next_corner(w);
      give(from, {accepted_[v] + std::sqrt(std::max(face.length2(side), 0.0)),
                  halfedge(face_of(corner), tail),
                  tail == c ? ArrivalLanes::kBendsAtTail : ArrivalLanes::kBendsAtHead});
    }
  }
}

void BackTracedFront::forget(std::uint32_t vertex) {
  distance_[vertex] = accepted_[vertex] = kUnreached;
  scratch_.vertices[vertex] = {};
}

void BackTracedFront::end() {
  for (FrontDomain& domain : domains_) {
    std::vector<std::uint32_t>& left = domain.round;
    left.clear();
    while (!domain.waiting.empty()) domain.waiting.take(left);
    for (const std::uint32_t v : left) {
      if (!scratch_.vertices[v].is_accepted()) forget(v);
    }
    for (std::vector<FrontEstimate>& handed : domain.handed_to) handed.clear();
    domain.late.clear();
  }
  rounds_in_bucket_ = 0;
  has_looked_ = false;
}

}  // namespace geodesic
