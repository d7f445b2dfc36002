// What the domains of a propagation share (domain.h). While they send windows out, distances,
// arrivals and upper bounds stay as they are; each domain changes only the lists of its own edges,
// when its own vertices last sent out windows, and the pseudo-sources that it makes. While they
// take in, each changes what is known of its own edges and vertices, and reads nothing of others'.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "core/base/block_domains.h"
#include "core/base/vectors.h"
#include "core/exact/frames.h"
#include "core/surface/triangulation.h"
#include "core/windows/window.h"

namespace geodesic::exact {

// How a vertex got its distance, for knowing where to it bends: through which
// corner, and where the straight line back meets the side opposite, counted from
// the corner after that one.
struct ArrivalAtVertex {
  std::uint32_t corner;  // kNone: it is a source, or nothing is known
  std::uint32_t pseudo_source : 31 = 0;
  std::uint32_t among_many : 1 = 0;  // one of many windows on that side led there
  double crossing = 0;
};

// Memory of one propagation that all domains share, kept for the next.
struct SharedMemory {
  Frames frames;
  std::vector<PseudoSource> pseudo_sources;
  std::vector<double> offsets;  // the pseudo-sources' own
  std::vector<ArrivalAtVertex> arrivals;
  std::vector<Bends> bends;
  std::vector<double> emitted;    // the distance at which a vertex last sent out windows
  std::vector<double> allowance;  // of the pseudo-source of a vertex's distance; with a tolerance
  // By edge: 1 + the number of a list that comes to it; 0 between rounds.
  std::vector<std::uint32_t> first_list;
};

struct SharedState {
  SharedMemory& memory;
  Triangulation surface;
  std::span<Edge> edges;
  std::span<double> distance;               // the field's, by vertex
  std::span<std::uint32_t> nearest_source;  // likewise, or empty
  double max;                               // what is farther is of no use
  double tolerance;
  Vectors vectors = best_vectors();
  // A new pseudo-source behind so many windows spares most of them. Of fewer, as on slivers
  // and flat parts, it makes more.
  std::size_t windows_for_early_source;
  BlockDomains by_edges;
  double edges_per_vertex;  // both are numbered along the same curve

  bool keeps_windows;
  bool keeps_some = false;         // only those of these:
  std::vector<bool> keep_of = {};  // by face
  std::vector<bool> keep_on = {};  // by edge

  [[nodiscard]] const Frames& frames() const { return memory.frames; }
  [[nodiscard]] bool keeps_windows_on(std::uint32_t e) const {
    return keeps_windows && (!keeps_some || keep_on[e]);
  }
  [[nodiscard]] std::uint32_t nearest(std::uint32_t v) const {
    return nearest_source.empty() ? 0 : nearest_source[v];
  }
  [[nodiscard]] double allowance(std::uint32_t v) const {
    return tolerance > 0 ? memory.allowance[v] : 0;
  }
  // Of two ways to a vertex that are as long, whether the first one is taken: whatever number their
  // pseudo-sources have. A source stays one.
  [[nodiscard]] bool is_before(const ArrivalAtVertex& a, const ArrivalAtVertex& b) const {
    if (a.corner == kNone || b.corner == kNone) return false;
    const PseudoSource& from_a = memory.pseudo_sources[a.pseudo_source];
    const PseudoSource& from_b = memory.pseudo_sources[b.pseudo_source];
    return std::tie(from_a.source, from_a.vertex, from_a.offset, a.corner, a.crossing) <
           std::tie(from_b.source, from_b.vertex, from_b.offset, b.corner, b.crossing);
  }
  // By how much earlier than it was reached a vertex may send out windows on its own.
  [[nodiscard]] double early_by(std::uint32_t v) const;

  [[nodiscard]] std::size_t domain_of_edge(std::uint32_t e) const {
    return by_edges.count() == 1 ? 0 : by_edges.of(e);
  }
  [[nodiscard]] std::size_t domain_of_vertex(std::uint32_t v) const {
    return by_edges.count() == 1 ? 0
                                 : by_edges.of(static_cast<std::uint32_t>(v * edges_per_vertex));
  }
};

}  // namespace geodesic::exact
