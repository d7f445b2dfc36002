#include "core/voronoi/near_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/tolerances.h"
#include "core/solve/solve_from_lines.h"

namespace geodesic {

std::uint32_t NearSites::nearest(std::uint32_t vertex) const {
  NearSite best{kNone, std::numeric_limits<double>::infinity()};
  for (const NearSite& near : of(vertex)) {
    if (near.square < best.square) best = near;
  }
  return best.site;
}

double NearSites::square(std::uint32_t vertex, std::uint32_t site) const {
  const auto near = of(vertex);
  const auto at = std::lower_bound(
      near.begin(), near.end(), site,
      [](const NearSite& entry, std::uint32_t number) { return entry.site < number; });
  return at != near.end() && at->site == site ? at->square : beyond_[vertex];
}

VoronoiSites points_of(const Field& field) {
  return {static_cast<std::uint32_t>(field.sources.size()),
          [&field](std::uint32_t site, SolveScratch&, const Cancel&) -> Result<VoronoiSite> {
            return VoronoiSite{{field.sources[site]}, nullptr};
          }};
}

class NearSitesBuilder {
 public:
  // `sites` must outlive this.
  NearSitesBuilder(Method method, const MethodOptions& options, const Adjacency& adjacency,
                   const Field& field, const VoronoiSites& sites, SolveScratch& scratch,
                   const Cancel& cancel)
      : method_(method),
        options_(options),
        adjacency_(adjacency),
        field_(field),
        sites_(sites),
        scratch_(scratch),
        cancel_(cancel),
        poll_(cancel),
        vertices_(adjacency.mesh().vertex_count()) {}

  Result<NearSites> build() {
    find_sides();
    find_unit();
    if (poll_.stopped()) return fail_stopped(poll_);
    if (field_.lines) {
      near_.waves_ = field_.lines;
      near_.is_line_.assign(sites_.count, false);
      find_tie();
    }
    if (sites_.count == 1) {
      add_single();
    } else {
      bound_cells();
      for (std::uint32_t site = 0; site < sites_.count; ++site) {
        if (auto added = add_site(site); !added) return fail(std::move(added.error()));
      }
      add_missing();
    }
    if (poll_.stopped()) return fail_stopped(poll_);
    sort();
    if (field_.lines) merge_ties();
    if (poll_.stopped()) return fail_stopped(poll_);
    return std::move(near_);
  }

 private:
  struct Entry {
    std::uint32_t vertex;
    NearSite near;
  };

  // Of each vertex the longest side of the faces there, and by it which sites are not near.
  void find_sides() {
    polled_assign(side_, vertices_, 0.0, poll_);
    if (poll_.stopped()) return;
    for (const FaceRecord& face : adjacency_.faces()) {
      if (poll_.cancelled()) return;
      const double longest = std::sqrt(std::max(face.longest2(), 0.0));
      for (const std::uint32_t v : face.vertex) side_[v] = std::max(side_[v], longest);
    }
  }

  void find_unit() {
    double most = 0;
    polled_assign(near_.beyond_, vertices_, 0.0, poll_);
    if (poll_.stopped()) return;
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      if (poll_.cancelled()) return;
      if (is_reached(v)) most = std::max(most, reach(v));
    }
    // Of distances that are all zero any unit will do.
    near_.unit_ = most > 0 ? std::ldexp(1.0, std::ilogb(most)) : 1;
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      if (poll_.cancelled()) return;
      if (is_reached(v)) near_.beyond_[v] = square(reach(v));
    }
  }

  [[nodiscard]] bool is_reached(std::uint32_t v) const { return field_.distance[v] != kUnreached; }
  [[nodiscard]] double reach(std::uint32_t v) const { return field_.distance[v] + 2 * side_[v]; }
  [[nodiscard]] double square(double distance) const {
    const double part = distance / near_.unit_;
    return part * part;
  }

  void add(std::uint32_t vertex, std::uint32_t site, double distance) {
    if (entries_.size() == entries_.capacity()) {
      const std::size_t more = std::max<std::size_t>(entries_.capacity(), 1024);
      if (!poll_.may_take(2 * more * sizeof(Entry))) return;
      entries_.reserve(entries_.size() + more);
    }
    entries_.push_back({vertex, {site, square(distance)}});
  }

  void add_single() {
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      if (poll_.cancelled()) return;
      if (is_reached(v)) add(v, 0, field_.distance[v]);
    }
  }

  [[nodiscard]] std::uint32_t label(std::uint32_t v) const {
    return field_.item_of_source(field_.nearest_source[v]);
  }

  // By how much distances of one vertex differ at most that count as the same.
  void find_tie() {
    const Box& box = adjacency_.mesh().box();
    tie_ = tolerance::kSamePath * norm(box.max - box.min);
    tie_part_ = tolerance::kSamePath;
    if (method_ == Method::back_traced)
      tie_part_ = options_.error_at_most.value_or(kToleranceFromLines);
  }
  [[nodiscard]] bool is_tie(double distance, double least) const {
    return std::abs(distance - least) <= tie_ + tie_part_ * least;
  }

  // How far each site's own field goes at first: over its cell, and the faces round it.
  void bound_cells() {
    bounds_.assign(sites_.count, 0);
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      if (poll_.cancelled()) return;
      if (!is_reached(v)) continue;
      double& bound = bounds_[label(v)];
      bound = std::max(bound, field_.distance[v] + kAround * side_[v]);
    }
  }
  // The same round the site itself, where its cell may have no vertex.
  [[nodiscard]] double bound_round(const VoronoiSite& site) {
    double bound = 0;
    const auto add = [&](std::uint32_t face, double offset) {
      if (face == kNone) return;
      for (const std::uint32_t v : adjacency_.face(face).vertex) {
        bound = std::max(bound, offset + kAround * side_[v]);
      }
    };
    for (const Source& source : site.sources) {
      if (poll_.cancelled()) return bound;
      add(source.point.face, source.offset);
    }
    if (!site.lines) return bound;
    for (const LineSegment& segment : site.lines->segments) {
      if (poll_.cancelled()) return bound;
      add(segment.face, 0);
    }
    return bound;
  }

  // The field of one site, by the way in which that of all was computed.
  Result<Field> solve(const VoronoiSite& site, const FieldLimits& limits, const Cancel& cancel) {
    if (!field_.lines) {
      return solve_field(method_, options_, adjacency_, site.sources, limits, scratch_, cancel);
    }
    std::shared_ptr<const SourceLines> lines = site.lines;
    if (!lines) {
      SourceLines none;
      none.item_of_source.assign(site.sources.size(), 0);
      lines = std::make_shared<const SourceLines>(std::move(none));
    }
    return solve_from_lines(method_, options_, adjacency_, site.sources, std::move(lines), limits,
                            scratch_, cancel);
  }

  Result<void> add_site(std::uint32_t number) {
    const auto count = static_cast<double>(sites_.count);
    double begin = number / count;
    const double end = (number + 1) / count;
    const auto site = sites_.at(number, scratch_, cancel_.part(begin, begin));
    if (!site) return fail(site.error());
    if (site->lines) near_.is_line_[number] = true;
    const std::size_t before = entries_.size();
    FieldLimits limits;
    limits.keep_details = false;
    limits.max = std::max(bounds_[number], bound_round(*site));
    if (poll_.stopped()) return fail_stopped(poll_);
    // The faces that a cell meets are joined over edges, for shortest paths to the site stay in it.
    // So all of them are found once the field goes beyond the faces round what is found.
    while (true) {
      const auto own = solve(*site, limits, cancel_.part(begin, end));
      if (!own) return fail(own.error());
      if (poll_.ask()) return fail_stopped(poll_);
      entries_.resize(before);
      double needed = 0;
      for (std::uint32_t v = 0; v < vertices_; ++v) {
        if (poll_.cancelled()) return fail_stopped(poll_);
        const double d = own->distance[v];
        if (d == kUnreached || !is_reached(v)) continue;
        if (!(d <= reach(v)) && label(v) != number) continue;
        add(v, number, d);
        needed = std::max(needed, d + 2 * side_[v]);
      }
      if (poll_.stopped()) return fail_stopped(poll_);
      if (needed <= limits.max) return {};
      limits.max = 1.25 * needed;
      begin = end;
    }
  }

  // By methods that are no metric a vertex may have no site that is near, but by the field it has.
  void add_missing() {
    std::vector<bool> has(vertices_);
    for (const Entry& entry : entries_) {
      if (poll_.cancelled()) return;
      has[entry.vertex] = true;
    }
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      if (poll_.cancelled()) return;
      if (!has[v] && is_reached(v)) add(v, label(v), field_.distance[v]);
    }
  }

  // By vertex; of each the sites stay in their order.
  void sort() {
    polled_assign(near_.begin_, std::size_t{vertices_} + 1, std::size_t{0}, poll_);
    polled_assign(near_.sites_, entries_.size(), NearSite{}, poll_);
    if (poll_.stopped()) return;
    for (const Entry& entry : entries_) {
      if (poll_.cancelled()) return;
      ++near_.begin_[entry.vertex + 1];
    }
    for (std::size_t v = 0; v < vertices_; ++v) near_.begin_[v + 1] += near_.begin_[v];
    std::vector<std::size_t> next;
    polled_copy(next, std::span<const std::size_t>(near_.begin_), poll_);
    if (poll_.stopped()) return;
    for (const Entry& entry : entries_) {
      if (poll_.cancelled()) return;
      near_.sites_[next[entry.vertex]++] = entry.near;
    }
  }

  // Distances of a vertex that count as the same become the least of them.
  void merge_ties() {
    std::vector<NearSite*> by_distance;
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      const std::size_t begin = near_.begin_[v];
      const std::size_t end = near_.begin_[v + 1];
      if (poll_.cancelled_after(end - begin + 1)) return;
      by_distance.clear();
      for (std::size_t i = begin; i < end; ++i) by_distance.push_back(&near_.sites_[i]);
      std::sort(by_distance.begin(), by_distance.end(),
                [](const NearSite* a, const NearSite* b) { return a->square < b->square; });
      const NearSite* least = nullptr;
      for (NearSite* site : by_distance) {
        if (least != nullptr && is_tie(distance_of(*site), distance_of(*least))) {
          site->square = least->square;
        } else {
          least = site;
        }
      }
    }
  }
  [[nodiscard]] double distance_of(const NearSite& site) const {
    return near_.unit_ * std::sqrt(site.square);
  }

  // In sides. Beyond a corner of 120 degrees what is near ends after four, and two more are needed
  // around that: so most sites need one field.
  static constexpr double kAround = 7;

  const Method method_;
  const MethodOptions& options_;
  const Adjacency& adjacency_;
  const Field& field_;
  const VoronoiSites& sites_;
  SolveScratch& scratch_;
  const Cancel& cancel_;
  Poll poll_;
  const std::uint32_t vertices_;
  NearSites near_;
  std::vector<double> side_;    // by vertex
  std::vector<double> bounds_;  // by site
  double tie_ = 0;              // mesh units
  double tie_part_ = 0;         // of the distance
  std::vector<Entry> entries_;
};

Result<NearSites> near_sites(Method method, const MethodOptions& options,
                             const Adjacency& adjacency, const Field& field,
                             const VoronoiSites& sites, SolveScratch& scratch,
                             const Cancel& cancel) {
  return NearSitesBuilder(method, options, adjacency, field, sites, scratch, cancel).build();
}

}  // namespace geodesic
