#include "core/exact/domain.h"

namespace geodesic::exact {
namespace {

// So many windows cross faces together, or more where an edge has more: each part of the work is
// done for all of them, and what one list waits for does not keep the others.
constexpr std::size_t kTogether = 256;

}  // namespace

void Domain::reset(std::size_t domains, double least, double width) {
  memory_.edges_waiting.reset(least, width);
  memory_.vertices_waiting.reset(least, width);
  // A query that was stopped may have left some.
  memory_.bounds.clear();
  memory_.early.clear();
  memory_.shorter.clear();
  memory_.entering.size = 0;
  memory_.over_faces.clear();
  memory_.lists_for.resize(domains);
  memory_.ways_for.resize(domains);
  forget_sent();
}

void Domain::forget_sent() {
  memory_.sent = 0;
  for (std::vector<HandedList>& lists : memory_.lists_for) lists.clear();
  for (std::vector<HandedWay>& ways : memory_.ways_for) ways.clear();
}

void Domain::begin_round(Poll& poll) {
  poll_ = &poll;
  forget_sent();
}

void Domain::send_out(Poll& poll) {
  begin_round(poll);
  memory_.vertices_waiting.take(memory_.taken_vertices);
  for (const Waiting& next : memory_.taken_vertices) bend_at(next.number);
  memory_.edges_waiting.take(memory_.taken);
  for (const Waiting& next : memory_.taken) {
    if (next.what != Waiting::What::edge) continue;
    state_.edges[next.number].queued = kUnreached;
    set_out(next.number);
    if (memory_.entering.size >= kTogether) cross_faces();
    if (poll.stopped()) return;
  }
  if (memory_.entering.size > 0) cross_faces();
  // After all, for in what order they wait depends on what else has waited in the domain.
  for (const Waiting& next : memory_.taken) {
    if (next.what == Waiting::What::bounded_edge) let_go(next.number);
  }
}

void Domain::take_in(std::span<Domain> all, Poll& poll) {
  poll_ = &poll;
  for (const auto& [e, farthest] : memory_.bounds) bound_edge(e, farthest);
  memory_.bounds.clear();
  for (const auto& [v, by] : memory_.early) {
    state_.distance[v] -= by;
    state_.memory.allowance[v] += by;
  }
  memory_.early.clear();
  for (Domain& other : all) {
    for (const HandedWay& way : other.memory_.ways_for[number_]) {
      relax(way.vertex, way.distance, pseudo_sources()[way.arrival.pseudo_source], way.arrival);
    }
    if (poll.cancelled_after(other.memory_.ways_for[number_].size())) return;
  }
  queue_vertices();
  take_lists(all);
}

}  // namespace geodesic::exact
