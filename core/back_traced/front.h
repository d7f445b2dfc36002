// The front of back_traced/wavefront.h: what one source's wave knows and does.
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
  // Each step leaves off, with nothing whole, when the poll says to stop. `distance` has an entry
  // per vertex, as have the scratch's vertices; they are
  // kUnreached and as constructed wherever this wave has not been.
  //
  // `domains`: 1, or into how many the vertices may be divided, at most Team::kMostParts.
  BackTracedFront(const Adjacency& adjacency, BackTrace::Rule rule, BackTracedScratch& scratch,
                  std::span<double> distance, std::size_t domains, Poll& poll);

  // Considers the vertices in the same face as the source, straight from there, and
  // those that a look around from the source finds visible from it, as far as no other source is
  // nearer.
  void start(const SurfacePoint& source, const detail::Worthwhile& worthwhile);

  // Accepts the next vertices: they get their distances, of several domains when they spread.
  // False, and none, when there are no more, or only such as are farther than `last` and by more
  // than `lag`.
  [[nodiscard]] bool accept_next(double last);
  // How many were accepted last.
  [[nodiscard]] std::size_t accepted_count() const;
  // Calls `tell(v)` for each of them. Among them are some for the second time: those whose estimate
  // was found to be too large just after they had been accepted.
  template <class Tell>
  void for_each_accepted(Tell tell) const {
    for (const FrontDomain& domain : domains_) {
      for (const std::uint32_t v : domain.round) tell(v);
    }
  }
  // Those for which `is_to_stop(v)` spread no further. Only of one domain: of several, the
  // distances of the round are still to be read.
  template <class Ask>
  void stop_where(Ask is_to_stop) {
    for (FrontDomain& domain : domains_) std::erase_if(domain.round, is_to_stop);
  }
  // Every triangle at those with two accepted vertices gives its third, the farthest, an
  // estimate.
  void spread();
  // Whether one that was accepted may be accepted again.
  [[nodiscard]] bool may_improve() const;

  // By how much a vertex may come after others that are farther.
  [[nodiscard]] double lag() const;
  [[nodiscard]] double distance(std::uint32_t vertex) const { return distance_[vertex]; }
  // The vertex is as if the wave had not come there.
  void forget(std::uint32_t vertex);
  // The same for all that were not accepted.
  void end();

 private:
  void see(std::uint32_t vertex, double straight);
  void lower(FrontDomain& own, std::uint32_t vertex, const FrontEstimate& estimate);
  void settle(FrontDomain& own, std::uint32_t vertex, const FrontEstimate& estimate);
  void look_ahead(FrontDomain& domain) const;
  void take_round(FrontDomain& domain, std::uint64_t bucket, double least, bool may_leave);
  [[nodiscard]] bool is_early(std::uint32_t vertex, double least) const;
  void trace_round(FrontDomain& domain, Poll& poll);
  void accept_round(FrontDomain& domain);
  void give_estimates(FrontDomain& domain, Poll& poll);
  void give(FrontDomain& from, const FrontEstimate& estimate);
  void spread_along_edges(FrontDomain& from, std::uint32_t vertex);
  void take_estimates(FrontDomain& domain);

  [[nodiscard]] FrontDomain& domain_of(std::uint32_t vertex) {
    return domains_[domains_.size() == 1 ? 0 : by_blocks_.of(vertex)];
  }
  // Does `work(domain, poll)` for each domain. It captures what Team::run says.
  template <class Work>
  void in_each_domain(Work work);
  [[nodiscard]] FrontState state(std::span<const double> distance) const {
    return {surface_, distance, scratch_.vertices, scratch_.crowds, rule_, vectors_};
  }

  const Adjacency& adjacency_;
  BackTrace::Rule rule_;
  BackTracedScratch& scratch_;
  std::span<double> distance_;
  // The same with those of the round that is being accepted, whose traces are not to see each
  // other. Of one domain it is that.
  std::span<double> accepted_;
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
};

}  // namespace geodesic
