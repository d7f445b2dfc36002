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

// The most distances of a vertex from different sources. With two, a vertex where three sources
// meet may be 2 to 10 % too far; with three and four, hardly any differs from eight.
constexpr std::size_t kMostSlots = 4;

// A vertex that was accepted in an earlier bucket waits again when its estimate turns out to be
// less by this part of it. With all that is less by anything, errors are the same.
constexpr double kLeastGainLater = 1e-4;

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
      vertices_(adjacency.mesh().vertex_count()),
      poll_(poll),
      surface_(adjacency.delaunay()) {
  // What is told of crowded edges depends on the order in which it is told.
  const std::size_t count = surface_.is_crowded ? 1 : domains;
  if (scratch.domains.size() < count) scratch.domains.resize(count);
  domains_ = std::span(scratch.domains).first(count);
  by_blocks_ = BlockDomains(vertices_, count);
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

BackTracedFront::BackTracedFront(const Adjacency& adjacency, BackTrace::Rule rule,
                                 BackTracedScratch& scratch, Poll& poll)
    : BackTracedFront(adjacency, rule, scratch, {}, 1, poll) {
  constexpr std::size_t kOfVertex = sizeof(double) + SourceSlots::kBytesOfSlot;
  const bool is_held =
      vertices_ <= std::min({scratch.distance.capacity(), scratch.slots.source.capacity(),
                             scratch.slots.next.capacity()});
  if (!is_held && !poll.may_take(vertices_ * kOfVertex)) return;
  scratch.distance.assign(vertices_, kUnreached);
  scratch.slots.reset(vertices_);
  distance_ = accepted_ = scratch.distance;
  slots_ = &scratch.slots;
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

// Inlined by force: it is most of what spreading does.
__attribute__((always_inline)) inline void BackTracedFront::lower(FrontDomain& own, Slot slot,
                                                                  const FrontEstimate& estimate) {
  const FrontVertex& known = scratch_.vertices[slot];
  const double before = std::abs(known.estimate);
  if (!(estimate.distance < before + least_gain_)) return;
  if (known.base == kNone && before < kUnreached) [[unlikely]] {
    own.late.push_back({slot, has_several_sources() ? slots_->source[slot] : 0, estimate});
    return;
  }
  settle(own, slot, estimate);
}

__attribute__((always_inline)) inline void BackTracedFront::settle(FrontDomain& own, Slot slot,
                                                                   const FrontEstimate& given) {
  const auto& [estimate, base, crossing] = given;
  FrontVertex& known = scratch_.vertices[slot];
  const double before = std::abs(known.estimate);
  // Visible from the source, but for those that go on past it, it has its base all the same.
  if (known.base == kNone && base != kNone && before < kUnreached) {
    known.base = base;
    known.crossing = crossing;
  }
  if (known.is_accepted()) {
    // It may have been too early: within a bucket, and where a face beside it is far larger than
    // those that others are reached over.
    if (!(estimate < before - least_gain_)) return;
    if (!own.waiting.is_now(before) && !(estimate < (1 - kLeastGainLater) * before)) return;
    known = {estimate, base, crossing};
    own.waiting.push_back(slot);
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
  own.waiting.push(slot, estimate, before);
}

void BackTracedFront::see(std::uint32_t vertex, double straight, std::uint32_t source) {
  if (!has_several_sources()) {
    if (!(straight < distance_[vertex])) return;
    distance_[vertex] = accepted_[vertex] = straight;
    if (surface_.is_crowded) scratch_.crowds.tell(surface_, vertex, straight);
    settle(domain_of(vertex), vertex, {straight, kNone, 0});
    return;
  }
  make_room(1);
  if (poll_.stopped()) return;
  const double delayed = straight + sources_[source].offset;
  if (!(delayed < kUnreached)) return;
  const Slot slot = take_slot(vertex, source, {delayed, kNone, 0});
  if (slot == kNone || !(straight < distance_[slot])) return;
  distance_[slot] = straight;
  settle(domains_[0], slot, {delayed, kNone, 0});
}

// What comes next in the domain. Those that were accepted by lesser estimates leave.
void BackTracedFront::look_ahead(FrontDomain& domain) const {
  domain.next = domain.waiting.first([&](Slot slot) {
    const FrontVertex& known = scratch_.vertices[slot];
    return !known.is_accepted() && known.estimate < kUnreached;
  });
  domain.least = kUnreached;
  const std::span<const Slot> slots = domain.waiting.vertices_of(domain.next);
  domain.waiting_next = slots.size();
  for (const Slot slot : slots) {
    const FrontVertex& known = scratch_.vertices[slot];
    domain.least = std::min(domain.least, known.estimate);
    __builtin_prefetch(&surface_.corner_begin[vertex_of(slot)]);
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
  std::vector<Slot>& round = domain.round;
  round.clear();
  domain.accepted = 0;
  domain.has_left_early = false;
  domain.waiting.go_to(bucket);
  if (domain.next != bucket) return;
  domain.waiting.take_now(round);
  std::size_t count = 0;
  for (const Slot slot : round) {
    if (may_leave && is_early(slot, least)) {
      domain.waiting.push_back(slot);
      continue;
    }
    round[count++] = slot;
    __builtin_prefetch(surface_.corners(vertex_of(slot)).data());
  }
  domain.has_left_early = count < round.size();
  domain.accepted = count;
  round.resize(count);
  // What is near in number is near in memory.
  if (has_lost_) {
    std::sort(round.begin(), round.end());
    round.erase(std::unique(round.begin(), round.end()), round.end());
    domain.accepted = round.size();
  } else {
    sort_few(round);  // of which no two are equal
  }
}

// Whether one of those to be accepted may yet have a say in the estimate of the vertex.
bool BackTracedFront::is_early(Slot slot, double least) const {
  const FrontVertex& known = scratch_.vertices[slot];
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
    const Slot slot = domain.round[i];
    distance_[slot] = domain.best[i];
    if (has_several_sources() && !(domain.best[i] < kUnreached)) [[unlikely]] {
      // An end of its base has lost its slot meanwhile. Another estimate may come.
      scratch_.vertices[slot] = {};
      has_lost_ = true;
      continue;
    }
    if (surface_.is_crowded) scratch_.crowds.tell(surface_, slot, domain.best[i]);
    scratch_.vertices[slot].estimate *= -1;
  }
  if (has_several_sources()) {
    std::erase_if(domain.round, [this](Slot slot) { return is_nearer_to_another(slot); });
  }
}

std::size_t BackTracedFront::accepted_count() const {
  std::size_t count = 0;
  if (has_several_sources()) {
    for (const Slot slot : domains_[0].round) count += slot < vertices_ ? 1 : 0;
    return count;
  }
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
  for (const Slot slot : domain.round) {
    const std::uint32_t v = vertex_of(slot);
    if (!adjacency_.is_pinched(v)) continue;
    if (has_several_sources()) make_room(2 * surface_.corners(v).size());
    if (poll.stopped()) return;
    spread_along_edges(domain, slot);
  }
  FrontRoom& room = domain.room;
  const std::size_t count = list_bases(state(accepted_), domain.round, room);
  if (has_several_sources()) make_room(count);
  if (poll.stopped()) return;
  const FrontState front = state(accepted_);
  const auto give = [&](std::size_t at, double distance, float crossing) {
    const std::uint32_t source = has_several_sources() ? room.sources_of_bases[at] : 0;
    this->give(domain, {distance, room.bases[at], crossing}, source);
  };
  arrive_over_bases(front, count, room, poll, give);
}

__attribute__((always_inline)) inline void BackTracedFront::give(FrontDomain& from,
                                                                 const FrontEstimate& estimate,
                                                                 std::uint32_t source) {
  const std::uint32_t vertex = opposite(surface_, estimate.base);
  if (has_several_sources()) {
    const double delayed = estimate.distance + sources_[source].offset;
    if (!(delayed < kUnreached)) return;  // an end of the base has lost its slot
    const FrontEstimate given{delayed, estimate.base, estimate.crossing};
    const Slot slot = take_slot(vertex, source, given);
    if (slot != kNone) lower(from, slot, given);
    return;
  }
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
      return std::tie(a.slot, a.estimate.distance, a.estimate.base, a.estimate.crossing) <
             std::tie(b.slot, b.estimate.distance, b.estimate.base, b.estimate.crossing);
    });
    for (const auto& [slot, source, estimate] : late) {
      // It may be another source's by now.
      if (has_several_sources() && slots_->source[slot] != source) continue;
      settle(domain, slot, estimate);
    }
    late.clear();
  }
  look_ahead(domain);
}

// Where faces meet in nothing but the vertex, no triangle beyond it has two accepted
// ones.
void BackTracedFront::spread_along_edges(FrontDomain& from, Slot slot) {
  const std::uint32_t source = has_several_sources() ? slots_->source[slot] : 0;
  for (const std::uint32_t corner : surface_.corners(vertex_of(slot))) {
    const FaceRecord& face = surface_.faces[face_of(corner)];
    const std::uint32_t c = corner_of(corner);
    for (const std::uint32_t side : {c, previous_corner(c)}) {
      const std::uint32_t w = side == c ? next_corner(c) : side;
      const std::uint32_t tail = next_corner(w);
      give(from,
           {accepted_[slot] + std::sqrt(std::max(face.length2(side), 0.0)),
            halfedge(face_of(corner), tail),
            tail == c ? ArrivalLanes::kBendsAtTail : ArrivalLanes::kBendsAtHead},
           source);
    }
  }
}

// Takes memory for so many slots more, so that nothing moves while estimates are given. Where there
// is none, the poll is stopped.
void BackTracedFront::make_room(std::size_t more) {
  const std::size_t most = kMostSlots * std::size_t{vertices_};
  const std::size_t wanted = std::min(slots_->size() + more, most);
  if (wanted <= distance_.size()) return;
  constexpr std::size_t kOfSlot = sizeof(FrontVertex) + sizeof(double) + SourceSlots::kBytesOfSlot;
  const std::size_t next = std::min(std::max(wanted, distance_.size() + vertices_ / 4), most);
  const bool is_held = next <= std::min({slots_->capacity(), scratch_.vertices.capacity(),
                                         scratch_.distance.capacity()});
  if (!is_held && !poll_.may_take(next * kOfSlot)) return;
  slots_->reserve(next);
  scratch_.vertices.reserve(next);
  if (scratch_.vertices.size() < next) scratch_.vertices.resize(next);
  scratch_.distance.reserve(next);
  scratch_.distance.resize(next, kUnreached);
  distance_ = accepted_ = scratch_.distance;
}

// Where an estimate of the vertex from this source is kept, with the offset. Of many sources the
// few with the least have a slot: who comes with less takes that of one that still waits. kNone:
// none.
Slot BackTracedFront::take_slot(std::uint32_t vertex, std::uint32_t source,
                                const FrontEstimate& given) {
  if (slots_->source[vertex] == kNone) {
    slots_->source[vertex] = source;
    return vertex;
  }
  Slot worst = kNone;
  std::pair most{given.distance, source};
  Slot last = kNone;
  std::size_t count = 0;
  for (Slot slot = vertex; slot != kNone; slot = slots_->next[slot], ++count) {
    if (slots_->source[slot] == source) return slot;
    last = slot;
    const FrontVertex& at = scratch_.vertices[slot];
    // One that waits again is the end of bases already: it has a distance, and a lesser estimate.
    const bool is_in_use = at.is_accepted() || (at.base != kNone && distance_[slot] < kUnreached &&
                                                at.estimate < with_offset(slot));
    const std::pair known{at.estimate, slots_->source[slot]};
    if (is_in_use || !(known > most)) continue;
    worst = slot;
    most = known;
  }
  if (count < kMostSlots) return slots_->add(vertex, last, source);
  if (worst == kNone) return kNone;
  FrontVertex& known = scratch_.vertices[worst];
  const double before = known.estimate;  // by that the queue has it
  slots_->source[worst] = source;
  distance_[worst] = kUnreached;
  known = {given.distance, given.base, given.crossing};
  domains_[0].waiting.push(worst, given.distance, before);
  return worst;
}

// The least of what is known of the vertex, with offsets.
double BackTracedFront::least_known(std::uint32_t vertex) const {
  double least = kUnreached;
  for (Slot slot = vertex; slot != kNone; slot = slots_->next[slot]) {
    least = std::min(least, std::abs(scratch_.vertices[slot].estimate));
  }
  return least;
}

double BackTracedFront::least_distance(std::uint32_t vertex) const {
  double least = kUnreached;
  for (Slot slot = vertex; slot != kNone; slot = slots_->next[slot]) {
    if (scratch_.vertices[slot].is_accepted()) least = std::min(least, with_offset(slot));
  }
  return least;
}

// Whether another source is nearer to the vertex of the slot, by more than a side there. Vertices
// on the other side of the line where two sources meet need those just beyond, and no more: with
// three mean edges in slot of a side errors are the same, with none they are up to 6 % there.
bool BackTracedFront::is_nearer_to_another(Slot slot) const {
  if (!(distance_[slot] < kUnreached)) return true;
  const double beyond = with_offset(slot) - least_distance(vertex_of(slot));
  if (!(beyond > 0)) return false;
  double longest2 = 0;  // also where the vertex is in no face
  for (const std::uint32_t corner : surface_.corners(vertex_of(slot))) {
    longest2 = std::max(longest2, surface_.faces[face_of(corner)].longest2());
  }
  return beyond * beyond > longest2;
}

void BackTracedFront::forget(Slot slot) {
  distance_[slot] = accepted_[slot] = kUnreached;
  if (has_several_sources()) slots_->source[slot] = kNone;
  scratch_.vertices[slot] = {};
}

void BackTracedFront::end() {
  for (FrontDomain& domain : domains_) {
    std::vector<Slot>& left = domain.round;
    left.clear();
    while (!domain.waiting.empty()) domain.waiting.take(left);
    for (const Slot slot : left) {
      if (!scratch_.vertices[slot].is_accepted()) forget(slot);
    }
    for (std::vector<FrontEstimate>& handed : domain.handed_to) handed.clear();
    domain.late.clear();
  }
  rounds_in_bucket_ = 0;
  has_looked_ = false;
  has_lost_ = false;
}

}  // namespace geodesic
