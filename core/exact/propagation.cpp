#include "core/exact/propagation.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/base/large_array.h"
#include "core/base/polled_fill.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/exact/field.h"

namespace geodesic::exact {
namespace {

// Behind so many windows on an edge a vertex may become a source. What starts
// little earlier than it was reached spares few of them, and its own meet the others at more
// places: the less the tolerance, the more there must be. Measured: 8 at 1e-2, 13 at 1e-3,
// 22 at 1e-4, beyond which it makes no difference.
std::size_t windows_for_early_source(double tolerance) {
  constexpr double kMost = 1e-2;
  constexpr double kLeast = 1e-4;
  const double part = kMost / std::clamp(tolerance, kLeast, kMost);
  return static_cast<std::size_t>(std::lround(8 * std::pow(part, 0.22)));
}

constexpr std::size_t kBytesOfPseudoSource = sizeof(PseudoSource) + sizeof(double);

// A round of fewer windows is soon done, and others are not told.
constexpr double kFewTogether = 256;

std::size_t count_domains(const Triangulation& surface, std::size_t vertices, const Poll& poll) {
  // Of faces that many share an edge, its domain alone would take in what they all send.
  if (surface.is_crowded || poll.team() == nullptr) return 1;
  return poll.team()->parts_for(kTimesAsLongByWindows * vertices);
}

}  // namespace

// By how much earlier than it was reached a vertex may send out windows on its own; 0
// where that is not worth the windows: where there are few windows to spare, or soon after an
// older one. Let p be the part of its distance that it may be
// early by, all in all: p of a distance is at most p / (1 - p) of that less p of it,
// which is the tolerance.
double SharedState::early_by(std::uint32_t v) const {
  // The least that is worth it, of what it may be in all and of an edge. With less of the
  // former, most of an older source's windows would be in the way of the new one's.
  constexpr double kWorthOfAll = 0.05;
  constexpr double kWorthOfSide = 6e-4;
  if (!(tolerance > 0) || !memory.arrivals[v].among_many) return 0;
  const double all = tolerance / (1 + tolerance) * distance[v];
  const double left = all - memory.allowance[v];
  return left > kWorthOfAll * all && left > kWorthOfSide * frames().mean_shortest_side() ? left : 0;
}

std::size_t PropagationMemory::window_bytes() const {
  std::size_t bytes = 0;
  for (const DomainMemory& domain : domains) bytes += domain.pool.bytes();
  return bytes;
}

Propagation::Propagation(const Adjacency& adjacency, const Triangulation& surface,
                         PropagationMemory& memory, Field& field, double max, double tolerance,
                         bool keep_windows, Poll& poll)
    : adjacency_(adjacency),
      poll_(poll),
      memory_(memory),
      field_(field),
      state_{.memory = memory.shared,
             .surface = surface,
             .edges = {},
             .distance = field.distance.doubles(),
             .nearest_source = field.nearest_source,
             .max = max * (1 + tolerance) * (1 + tolerance),
             .tolerance = tolerance,
             .windows_for_early_source = windows_for_early_source(tolerance),
             .by_edges = {},
             .edges_per_vertex = 1,
             .keeps_windows = keep_windows} {
  SharedMemory& shared = memory.shared;
  shared.frames.build(adjacency, surface, poll);
  if (poll.stopped()) return;
  state_.edges = shared.frames.edges();
  const std::size_t vertex_count = surface.corner_begin.size() - 1;
  const std::size_t count = count_domains(surface, vertex_count, poll);
  state_.by_edges = BlockDomains(state_.edges.size(), count);
  state_.edges_per_vertex =
      static_cast<double>(state_.edges.size()) / static_cast<double>(vertex_count);
  if (memory.domains.size() < count) memory.domains.resize(count);
  double least = kUnreached;
  for (const Source& source : field.sources) least = std::min(least, source.offset);
  for (std::size_t i = 0; i < memory.domains.size(); ++i) {
    DomainMemory& domain = memory.domains[i];
    domain.pool.reset(poll, memory.domains.size());
    if (poll.stopped()) return;
    if (i >= count) continue;
    domains_.emplace_back(state_, domain, i)
        .reset(count, least, 0.25 * shared.frames.mean_shortest_side());
  }
  shared.pseudo_sources.clear();
  shared.offsets.clear();
  shared.arrivals.assign(vertex_count, {kNone});
  shared.bends.assign(shared.frames.bends().begin(), shared.frames.bends().end());
  // Mostly, each vertex where paths bend sends out windows once.
  const auto bending = static_cast<std::size_t>(std::count_if(
      shared.bends.begin(), shared.bends.end(), [](Bends b) { return b != Bends::nowhere; }));
  shared.pseudo_sources.reserve(bending + field.sources.size());
  shared.offsets.reserve(bending + field.sources.size());
  shared.emitted.assign(vertex_count, kUnreached);
  shared.allowance.assign(tolerance > 0 ? vertex_count : 0, 0);
  shared.first_list.assign(state_.edges.size(), 0);
}

void Propagation::keep_windows_of(std::span<const std::uint32_t> faces) {
  state_.keeps_some = true;
  state_.keep_of.assign(state_.surface.faces.size(), false);
  state_.keep_on.assign(state_.edges.size(), false);
  for (const std::uint32_t f : faces) {
    state_.keep_of[f] = true;
    for (const std::uint32_t e : state_.frames().face(f).edge) state_.keep_on[e] = true;
  }
}

std::uint32_t Propagation::add_pseudo_source(const PseudoSource& pseudo_source) {
  SharedMemory& shared = memory_.shared;
  shared.pseudo_sources.push_back(pseudo_source);
  shared.offsets.push_back(pseudo_source.offset);
  return static_cast<std::uint32_t>(shared.pseudo_sources.size() - 1);
}

template <class Work>
void Propagation::in_each_domain(bool is_worth_it, Work work) {
  if (domains_.size() == 1 || !is_worth_it) {
    for (Domain& domain : domains_) work(domain, poll_);
    return;
  }
  run_parts(domains_.size(), poll_,
            [this, work](std::size_t number, Poll& poll) { work(domains_[number], poll); });
}

void Propagation::start(const Source& source, std::uint32_t number) {
  if (source.offset > state_.max) return;
  Domain& domain = domains_.front();
  domain.begin_round(poll_);
  const std::uint32_t v = source.point.vertex;
  if (!source.point.at_vertex()) {
    const std::uint32_t pseudo_source = add_pseudo_source({source.offset, kNone, number});
    for (const PlaceInFace& place : places_on(adjacency_, state_.surface, source.point, poll_)) {
      if (poll_.cancelled()) return;
      bend_at_corners_of(place);
      domain.send_inside(place, pseudo_source);
    }
  } else if (source.offset < state_.distance[v]) {
    state_.distance[v] = source.offset;
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = number;
    memory_.shared.arrivals[v].corner = kNone;
    memory_.shared.bends[v] = Bends::everywhere;
    memory_.shared.emitted[v] = source.offset;
    domain.send_everywhere(v, add_pseudo_source({source.offset, kNone, number}));
  }
  for (Domain& each : domains_) each.take_in(std::span(domains_).first(1), poll_);
}

void Propagation::bend_at_corners_of(const PlaceInFace& place) {
  const FaceRecord& face = state_.surface.faces[place.face];
  const double beside = tolerance::kBesideCorner * std::sqrt(face.longest2());
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (place.to_corner[c] <= beside) {
      memory_.shared.bends[face.vertex[c]] = Bends::everywhere;
    }
  }
}

bool Propagation::step() {
  std::uint64_t bucket = BucketQueue::kNever;
  for (const DomainMemory& domain : used_memory()) {
    bucket = std::min({bucket, domain.edges_waiting.next(), domain.vertices_waiting.next()});
  }
  if (bucket == BucketQueue::kNever) return false;
  std::size_t waiting = 0;
  for (DomainMemory& domain : used_memory()) {
    domain.edges_waiting.go_to(bucket);
    domain.vertices_waiting.go_to(bucket);
    waiting += domain.edges_waiting.count_now() + domain.vertices_waiting.count_now();
  }
  make_room_for_pseudo_sources();
  bool is_worth_it = false;
  if (domains_.size() > 1) {
    for (DomainMemory& domain : used_memory()) {
      sent_ += domain.sent;
      domain.make_ready(domains_.size(), poll_);
    }
    // As many windows of each that waits as there were until now.
    const double windows = static_cast<double>(waiting) * sent_ / std::max(1.0, set_out_);
    is_worth_it = windows >= kFewTogether;
    set_out_ += static_cast<double>(waiting);
  }
  in_each_domain(is_worth_it, [](Domain& domain, Poll& poll) { domain.send_out(poll); });
  if (poll_.stopped()) return true;
  forget_room_for_pseudo_sources();
  in_each_domain(is_worth_it,
                 [this](Domain& domain, Poll& poll) { domain.take_in(domains_, poll); });
  return true;
}

// Room for one of each vertex that waits, by domain. More wait than will be made: some are not
// nearer than before.
void Propagation::make_room_for_pseudo_sources() {
  SharedMemory& shared = memory_.shared;
  std::size_t size = shared.pseudo_sources.size();
  for (DomainMemory& domain : used_memory()) {
    domain.next_pseudo_source = static_cast<std::uint32_t>(size);
    size += domain.vertices_waiting.count_now();
  }
  // What is refused, the computation learns when it polls next.
  if (size > shared.pseudo_sources.capacity())
    (void)poll_.may_take(2 * size * kBytesOfPseudoSource);
  shared.pseudo_sources.resize(size);
  shared.offsets.resize(size);
}

void Propagation::forget_room_for_pseudo_sources() {
  const std::uint32_t used = used_memory().back().next_pseudo_source;
  memory_.shared.pseudo_sources.resize(used);
  memory_.shared.offsets.resize(used);
}

double Propagation::final_below() const {
  return memory_.domains.front().edges_waiting.now() / (1 + state_.tolerance);
}

std::uint64_t Propagation::reached() const {
  std::uint64_t sum = 0;
  for (const Domain& domain : domains_) sum += domain.reached();
  return sum;
}

std::uint64_t Propagation::propagated() const {
  std::uint64_t sum = 0;
  for (const Domain& domain : domains_) sum += domain.propagated();
  return sum;
}

void Propagation::raise_to_paths(Poll& poll) {
  const std::vector<double>& allowance = memory_.shared.allowance;
  for (std::uint32_t v = 0; v < allowance.size() && !poll.cancelled(); ++v) {
    state_.distance[v] += allowance[v];
  }
}

bool Propagation::relax_along_edges(Poll& poll) {
  bool any = false;
  for (std::uint32_t e = 0; e < state_.frames().edges().size() && !poll.cancelled(); ++e) {
    const Edge& frame = state_.frames().edge(e);
    for (const auto& [from, to] :
         {std::pair{frame.tail, frame.head}, std::pair{frame.head, frame.tail}}) {
      const double distance = state_.distance[from] + frame.length;
      if (!(distance < state_.distance[to] * (1 - tolerance::kLostWindow)) || distance > state_.max)
        continue;
      memory_.shared.bends[to] = Bends::everywhere;
      domains_[state_.domain_of_vertex(to)].relax(
          to, distance, {state_.distance[from], from, state_.nearest(from), state_.allowance(from)},
          {kNone});
      any = true;
    }
  }
  for (Domain& domain : domains_) domain.queue_vertices();
  return any;
}

void Propagation::drop_windows(Poll& poll) {
  for (DomainMemory& domain : memory_.domains) domain.pool.reset(poll, memory_.domains.size());
}

WindowTable Propagation::window_table(Poll& poll) const {
  constexpr std::size_t kAhead = 4;  // edges whose windows are fetched before their turn
  const std::span<const FaceRecord> faces = state_.surface.faces;
  const auto keeps = [&](std::uint32_t f) { return !state_.keeps_some || state_.keep_of[f]; };
  // Room for all, and some more where only some faces keep theirs: a window sees into every face at
  // its edge but the one that it came over.
  std::uint64_t room = 0;
  for (std::uint32_t f = 0; f < faces.size() && !poll.cancelled(); ++f) {
    if (!keeps(f)) continue;
    for (const std::uint32_t e : state_.frames().face(f).edge) room += state_.edges[e].size;
  }
  if (!state_.keeps_some) {
    for (std::uint32_t e = 0; e < state_.edges.size() && !poll.cancelled(); ++e) {
      room -= state_.edges[e].size;
    }
  }
  if (!poll.stopped() && room > WindowTable::kMostWindows) throw std::bad_alloc();
  std::vector<WindowTable::Part> parts;
  polled_assign(parts, 4 * faces.size(), WindowTable::Part{}, poll);
  LargeArray<VisibleInterval> intervals(room, poll);
  std::uint32_t count = 0;
  for (std::uint32_t e = 0; e < state_.edges.size() && !poll.cancelled(); ++e) {
    if (!state_.keeps_windows_on(e)) continue;
    if (e + kAhead < state_.edges.size()) __builtin_prefetch(state_.edges[e + kAhead].windows);
    const Edge& edge = state_.edges[e];
    if (edge.size == 0) continue;
    Halfedge h = edge.first;
    do {
      if (keeps(face_of(h))) {
        const std::uint32_t begin = count;
        for (std::uint32_t i = 0; i < edge.size; ++i) {
          const Window& w = edge.windows[state_.frames().is_reversed(h) ? edge.size - 1 - i : i];
          if (w.from != h) intervals[count++] = visible_interval(w, edge, h);
        }
        parts[h] = {begin, count - begin};
      }
      h = state_.surface.ring(h);
    } while (h != edge.first && !poll.cancelled_after(edge.size));
  }
  return {std::move(parts), std::move(intervals)};
}

// A window of the edge, as the face of one of its halfedges has it.
VisibleInterval Propagation::visible_interval(const Window& w, const Edge& edge, Halfedge h) const {
  const PseudoSource& pseudo_source = memory_.shared.pseudo_sources[w.pseudo_source];
  // What a window leads along is the length of a path, as raise_to_paths makes vertices'.
  const double offset = pseudo_source.offset + pseudo_source.allowance;
  if (state_.frames().is_reversed(h)) {
    return {edge.length - w.end,  edge.length - w.begin, edge.length - w.x, w.y, offset,
            pseudo_source.vertex, pseudo_source.source};
  }
  return {w.begin, w.end, w.x, w.y, offset, pseudo_source.vertex, pseudo_source.source};
}

}  // namespace geodesic::exact
