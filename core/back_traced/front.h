// The front of back_traced/wavefront.h: what a wave knows and does.
//
// It goes in rounds. The considered vertices with the least estimates, all within a small
// part of an edge, are accepted together: first they all get their distances, none of
// which depends on another, then they all give their neighbours estimates. So what needs
// arithmetic is done in lanes, and what lies apart in memory is fetched ahead.
//
// Where threads help (base/team.h), the vertices are divided among as many FrontDomains, by blocks
// of numbers that are near each other. Each step of a round is done for all domains at once, and
// only the domain of a vertex changes what is known of it: estimates for the vertices of another
// are handed to that one. Of the estimates of one round, those that come first and last are treated
// alike. So no result depends on how many domains there are.
//
// A wave from several sources keeps a few distances of a vertex, from different sources, and goes
// on from each (front_distances.h). From a vertex that is clearly nearer to another source it goes
// no further. What is said of a vertex here is then of one of its slots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/back_traced/front_part.h"
#include "core/back_traced/scratch.h"
#include "core/back_traced/trace.h"
#include "core/base/block_domains.h"
#include "core/base/cancel.h"
#include "core/base/vectors.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/triangulation.h"
#include "core/wavefront/waves.h"

namespace geodesic {

class BackTracedFront {
 public:
  // Each step leaves off, with nothing whole, when the poll says to stop. `distance`, without the
  // source's offset, has an entry per vertex, as have the scratch's vertices; they are kUnreached
  // and as constructed wherever this wave has not been.
  //
  // `domains`: 1, or into how many the vertices may be divided, at most Team::kMostParts.
  BackTracedFront(const Adjacency& adjacency, BackTrace::Rule rule, BackTracedScratch& scratch,
                  std::span<double> distance, std::size_t domains, Poll& poll);
  // Of several sources. What it finds is in the scratch's distances and slots. The scratch's
  // vertices are as constructed.
  BackTracedFront(const Adjacency& adjacency, BackTrace::Rule rule, BackTracedScratch& scratch,
                  Poll& poll);

  // Considers the vertices in the same face as each source, straight from there, and those that a
  // look around from the source finds visible from it, as far as no other source is nearer. The
  // sources must outlive this object.
  void start(std::span<const Source> sources, const detail::Worthwhile& worthwhile);

  // Accepts the next vertices: they get their distances, of several domains when they spread.
  // False, and none, when there are no more, or only such as come after `last`, to which the caller
  // has added `lag`.
  [[nodiscard]] bool accept_next(double last);
  // How many were accepted last.
  [[nodiscard]] std::size_t accepted_count() const;
  // Calls `tell(v)` for each of them, but for those that are clearly nearer to another source.
  // Among them are some for the second time: those whose estimate was found to be too large just
  // after they had been accepted.
  template <class Tell>
  void for_each_accepted(Tell tell) const {
    for (const FrontDomain& domain : domains_) {
      for (const Slot slot : domain.round) tell(vertex_of(slot));
    }
  }
  // Those for which `is_to_stop(v, distance)` spread no further. Only of one domain: of several,
  // the distances of the round are still to be read.
  template <class Ask>
  void stop_where(Ask is_to_stop) {
    for (FrontDomain& domain : domains_) {
      std::erase_if(domain.round,
                    [&](Slot slot) { return is_to_stop(vertex_of(slot), distance_[slot]); });
    }
  }
  // Every triangle at those with two accepted vertices gives its third, the farthest, an
  // estimate.
  void spread();
  // Whether one that was accepted may be accepted again.
  [[nodiscard]] bool may_improve() const;

  // By how much a vertex may come after others that are farther.
  [[nodiscard]] double lag() const;
  [[nodiscard]] double distance(Slot slot) const { return distance_[slot]; }
  // Of several sources, the least of the vertex's, with the source's offset; kUnreached: none.
  [[nodiscard]] double least_distance(std::uint32_t vertex) const;
  // As if the wave had not come there.
  void forget(Slot slot);
  // The same for all that were not accepted.
  void end();

 private:
  void look_out_of_faces(std::uint32_t source, std::vector<VisibilityCone>& cones,
                         std::size_t most);
  void see(std::uint32_t vertex, double straight, std::uint32_t source);
  void lower(FrontDomain& own, Slot slot, const FrontEstimate& estimate);
  void settle(FrontDomain& own, Slot slot, const FrontEstimate& estimate);
  void look_ahead(FrontDomain& domain) const;
  void take_round(FrontDomain& domain, std::uint64_t bucket, double least, bool may_leave);
  [[nodiscard]] bool is_early(Slot slot, double least) const;
  void trace_round(FrontDomain& domain, Poll& poll);
  void accept_round(FrontDomain& domain);
  void give_estimates(FrontDomain& domain, Poll& poll);
  void give(FrontDomain& from, const FrontEstimate& estimate, std::uint32_t source);
  void spread_along_edges(FrontDomain& from, Slot slot);
  void take_estimates(FrontDomain& domain);

  // Of several sources:
  [[nodiscard]] Slot take_slot(std::uint32_t vertex, std::uint32_t source,
                               const FrontEstimate& given);
  [[nodiscard]] double least_known(std::uint32_t vertex) const;
  [[nodiscard]] bool is_nearer_to_another(Slot slot) const;
  [[nodiscard]] double with_offset(Slot slot) const {
    return distance_[slot] + sources_[slots_->source[slot]].offset;
  }
  void make_room(std::size_t more);

  [[nodiscard]] bool has_several_sources() const { return slots_ != nullptr; }
  [[nodiscard]] std::uint32_t vertex_of(Slot slot) const {
    return slot < vertices_ ? slot : slots_->vertex_of(slot);
  }
  [[nodiscard]] FrontDomain& domain_of(std::uint32_t vertex) {
    return domains_[domains_.size() == 1 ? 0 : by_blocks_.of(vertex)];
  }
  // Does `work(domain, poll)` for each domain. It captures what Team::run says.
  template <class Work>
  void in_each_domain(Work work);
  [[nodiscard]] FrontState state(std::span<const double> distance) const {
    return {surface_,          FrontDistances(distance, slots_),
            scratch_.vertices, sources_,
            scratch_.crowds,   rule_,
            vectors_};
  }

  const Adjacency& adjacency_;
  BackTrace::Rule rule_;
  BackTracedScratch& scratch_;
  std::span<double> distance_;
  // The same with those of the round that is being accepted, whose traces are not to see each
  // other. Of one domain it is that.
  std::span<double> accepted_;
  std::uint32_t vertices_;
  SourceSlots* slots_ = nullptr;  // null: there is one source
  std::span<const Source> sources_;
  double overlap_ = 0;  // by how much farther than another source one looks around
  Poll& poll_;
  Triangulation surface_;  // what this wave goes over
  double least_gain_ = 0;  // that makes an accepted vertex wait again
  Vectors vectors_ = best_vectors();
  std::span<FrontDomain> domains_;  // those of the scratch that are in use
  BlockDomains by_blocks_;          // of vertices

  // Changed between steps, apart from what is read in them.
  alignas(64) int rounds_in_bucket_ = 0;
  bool has_looked_ = false;  // at what comes next
  bool is_small_ = false;    // the round
  // Whether a slot no longer waits by an estimate that the queue still has it for.
  bool has_lost_ = false;
};

}  // namespace geodesic
