#include "core/voronoi/near_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/polled_fill.h"

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

class NearSitesBuilder {
 public:
  NearSitesBuilder(Method method, const MethodOptions& options, const Adjacency& adjacency,
                   const Field& field, SolveScratch& scratch, const Cancel& cancel)
      : method_(method),
        options_(options),
        adjacency_(adjacency),
        field_(field),
        scratch_(scratch),
        cancel_(cancel),
        poll_(cancel),
        vertices_(adjacency.mesh().vertex_count()) {}

  Result<NearSites> build() {
    find_sides();
    find_unit();
    if (poll_.stopped()) return fail_stopped(poll_);
    if (field_.sources.size() == 1) {
      add_single();
    } else {
      bound_cells();
      for (std::uint32_t site = 0; site < field_.sources.size(); ++site) {
        if (auto added = add_site(site); !added) return fail(std::move(added.error()));
      }
      add_missing();
    }
    if (poll_.stopped()) return fail_stopped(poll_);
    sort();
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

  // How far each site's own field goes at first: over its cell, and the faces round it.
  void bound_cells() {
    bounds_.assign(field_.sources.size(), 0);
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      if (poll_.cancelled()) return;
      if (!is_reached(v)) continue;
      double& bound = bounds_[field_.nearest_source[v]];
      bound = std::max(bound, field_.distance[v] + kAround * side_[v]);
    }
    for (std::uint32_t s = 0; s < bounds_.size(); ++s) {
      const Source& source = field_.sources[s];
      if (source.point.face == kNone) continue;
      for (const std::uint32_t v : adjacency_.face(source.point.face).vertex) {
        bounds_[s] = std::max(bounds_[s], source.offset + kAround * side_[v]);
      }
    }
  }

  Result<void> add_site(std::uint32_t site) {
    const auto count = static_cast<double>(field_.sources.size());
    double begin = site / count;
    const double end = (site + 1) / count;
    const std::size_t before = entries_.size();
    FieldLimits limits;
    limits.keep_details = false;
    limits.max = bounds_[site];
    // The faces that a cell meets are joined over edges, for shortest paths to the site stay in it.
    // So all of them are found once the field goes beyond the faces round what is found.
    while (true) {
      const auto own = solve_field(method_, options_, adjacency_, {&field_.sources[site], 1},
                                   limits, scratch_, cancel_.part(begin, end));
      if (!own) return fail(own.error());
      if (poll_.ask()) return fail_stopped(poll_);
      entries_.resize(before);
      double needed = 0;
      for (std::uint32_t v = 0; v < vertices_; ++v) {
        if (poll_.cancelled()) return fail_stopped(poll_);
        const double d = own->distance[v];
        if (d == kUnreached || !is_reached(v)) continue;
        if (!(d <= reach(v)) && field_.nearest_source[v] != site) continue;
        add(v, site, d);
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
      if (!has[v] && is_reached(v)) add(v, field_.nearest_source[v], field_.distance[v]);
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

  // In sides. Beyond a corner of 120 degrees what is near ends after four, and two more are needed
  // around that: so most sites need one field.
  static constexpr double kAround = 7;

  const Method method_;
  const MethodOptions& options_;
  const Adjacency& adjacency_;
  const Field& field_;
  SolveScratch& scratch_;
  const Cancel& cancel_;
  Poll poll_;
  const std::uint32_t vertices_;
  NearSites near_;
  std::vector<double> side_;    // by vertex
  std::vector<double> bounds_;  // by site
  std::vector<Entry> entries_;
};

Result<NearSites> near_sites(Method method, const MethodOptions& options,
                             const Adjacency& adjacency, const Field& field, SolveScratch& scratch,
                             const Cancel& cancel) {
  return NearSitesBuilder(method, options, adjacency, field, scratch, cancel).build();
}

}  // namespace geodesic
