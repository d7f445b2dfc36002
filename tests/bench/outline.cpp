#include "tests/bench/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace geodesic::bench {
namespace {

double cross(OutlinePoint a, OutlinePoint b, OutlinePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool is_inside(OutlinePoint p, OutlinePoint a, OutlinePoint b, OutlinePoint c) {
  return cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
}

bool is_same(OutlinePoint a, OutlinePoint b) { return a.x == b.x && a.y == b.y; }

// A hole becomes part of the outline by a bridge there and back, from its rightmost point.
void join_hole(std::vector<std::uint32_t>& outline, const std::vector<std::uint32_t>& hole,
               const std::vector<OutlinePoint>& points) {
  const auto right = static_cast<std::size_t>(
      std::max_element(hole.begin(), hole.end(),
                       [&](auto a, auto b) { return points[a].x < points[b].x; }) -
      hole.begin());
  const OutlinePoint from = points[hole[right]];
  const auto is_free = [&](OutlinePoint to) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const OutlinePoint a = points[outline[i]];
      const OutlinePoint b = points[outline[(i + 1) % outline.size()]];
      if (is_same(a, to) || is_same(b, to)) continue;
      if (cross(from, to, a) * cross(from, to, b) <= 0 &&
          cross(a, b, from) * cross(a, b, to) <= 0) {
        return false;
      }
    }
    return true;
  };
  std::size_t nearest = outline.size();
  double least = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const OutlinePoint to = points[outline[i]];
    const double d = std::hypot(to.x - from.x, to.y - from.y);
    if (to.x < from.x || (nearest < outline.size() && d >= least) || !is_free(to)) continue;
    // Of a point that two bridges share, the place from which the hole is seen.
    const OutlinePoint before = points[outline[(i + outline.size() - 1) % outline.size()]];
    const OutlinePoint after = points[outline[(i + 1) % outline.size()]];
    const bool is_convex = cross(before, to, after) >= 0;
    const bool left_of_both = cross(before, to, from) > 0 && cross(to, after, from) > 0;
    const bool left_of_one = cross(before, to, from) > 0 || cross(to, after, from) > 0;
    if (is_convex ? !left_of_both : !left_of_one) continue;
    nearest = i;
    least = d;
  }
  if (nearest == outline.size()) return;
  std::vector<std::uint32_t> way;
  for (std::size_t i = 0; i <= hole.size(); ++i) way.push_back(hole[(right + i) % hole.size()]);
  way.push_back(outline[nearest]);
  outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(nearest) + 1, way.begin(),
                 way.end());
}

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Meisters, "Polygons have ears", Amer. Math. Monthly 82, 1975.
Triangles clip_ears(std::vector<std::uint32_t> outline, const std::vector<OutlinePoint>& points) {
  Triangles triangles;
  std::size_t i = 0;
  std::size_t refused = 0;
  while (outline.size() > 3 && refused <= outline.size()) {
    const std::size_t n = outline.size();
    i %= n;
    const std::uint32_t a = outline[i];
    const std::uint32_t b = outline[(i + 1) % n];
    const std::uint32_t c = outline[(i + 2) % n];
    bool is_ear = cross(points[a], points[b], points[c]) > 0;
    for (std::size_t k = 0; is_ear && k < n; ++k) {
      const OutlinePoint p = points[outline[k]];
      if (is_same(p, points[a]) || is_same(p, points[b]) || is_same(p, points[c])) continue;
      is_ear = !is_inside(p, points[a], points[b], points[c]);
    }
    if (!is_ear) {
      ++i;
      ++refused;
      continue;
    }
    refused = 0;
    triangles.push_back({a, b, c});
    outline.erase(outline.begin() + static_cast<std::ptrdiff_t>((i + 1) % n));
  }
  if (outline.size() == 3) triangles.push_back({outline[0], outline[1], outline[2]});
  return triangles;
}

}  // namespace

Outline circle(OutlinePoint centre, double radius, std::uint32_t points, bool clockwise) {
  Outline outline;
  for (std::uint32_t i = 0; i < points; ++i) {
    const double angle = (clockwise ? -2 : 2) * std::numbers::pi * i / points;
    outline.push_back({centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle)});
  }
  return outline;
}

TriangleSoup extrusion(const Outline& outer, const std::vector<Outline>& holes, double height,
                       std::uint32_t rings) {
  std::vector<OutlinePoint> points;
  std::vector<std::vector<std::uint32_t>> outlines;
  const auto add = [&](const Outline& outline) {
    outlines.emplace_back();
    for (const OutlinePoint p : outline) {
      outlines.back().push_back(static_cast<std::uint32_t>(points.size()));
      points.push_back(p);
    }
  };
  add(outer);
  for (const Outline& hole : holes) add(hole);
  const auto count = static_cast<std::uint32_t>(points.size());
  TriangleSoup soup;
  for (std::uint32_t r = 0; r <= rings; ++r) {
    for (const OutlinePoint p : points) soup.positions.push_back({p.x, p.y, height * r / rings});
  }
  std::vector<std::uint32_t> whole = outlines[0];
  std::vector<std::size_t> order;
  for (std::size_t h = 1; h < outlines.size(); ++h) order.push_back(h);
  const auto right = [&](std::size_t h) {
    double x = points[outlines[h][0]].x;
    for (const std::uint32_t p : outlines[h]) x = std::max(x, points[p].x);
    return x;
  };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return right(a) > right(b); });
  for (const std::size_t h : order) join_hole(whole, outlines[h], points);
  const std::uint32_t top = rings * count;
  for (const auto& [a, b, c] : clip_ears(whole, points)) {
    soup.faces.push_back({c, b, a});
    soup.faces.push_back({top + a, top + b, top + c});
  }
  for (const std::vector<std::uint32_t>& outline : outlines) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      for (std::uint32_t r = 0; r < rings; ++r) {
        const std::uint32_t a = r * count + outline[i];
        const std::uint32_t b = r * count + outline[(i + 1) % outline.size()];
        soup.faces.push_back({a, b, b + count});
        soup.faces.push_back({a, b + count, a + count});
      }
    }
  }
  return soup;
}

TriangleSoup turned(const std::vector<ProfilePoint>& profile, std::uint32_t around) {
  TriangleSoup soup;
  std::vector<std::uint32_t> begin;
  for (const auto& [radius, z] : profile) {
    begin.push_back(static_cast<std::uint32_t>(soup.positions.size()));
    for (std::uint32_t i = 0; i < (radius > 0 ? around : 1); ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      soup.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  }
  for (std::size_t row = 0; row + 1 < profile.size(); ++row) {
    const auto at = [&](std::size_t r, std::uint32_t i) {
      return begin[r] + (profile[r].radius > 0 ? i % around : 0);
    };
    for (std::uint32_t i = 0; i < around; ++i) {
      if (profile[row].radius > 0) {
        soup.faces.push_back({at(row, i), at(row, i + 1), at(row + 1, i)});
      }
      if (profile[row + 1].radius > 0) {
        soup.faces.push_back({at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)});
      }
    }
  }
  return soup;
}

TriangleSoup cut_off(const TriangleSoup& solid, Vec3 normal, Vec3 at) {
  TriangleSoup soup = solid;
  soup.faces.clear();
  std::vector<double> above;
  for (const Vec3& p : solid.positions) {
    const double h = dot(p - at, normal);
    above.push_back(h == 0 ? 1e-300 : h);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> crossings;
  const auto crossing = [&](std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [found, is_new] =
        crossings.try_emplace({a, b}, static_cast<std::uint32_t>(soup.positions.size()));
    if (is_new) {
      const Vec3 p = solid.positions[a];
      const Vec3 q = solid.positions[b];
      const double t = above[a] / (above[a] - above[b]);
      soup.positions.push_back(
          {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), p.z + t * (q.z - p.z)});
    }
    return found->second;
  };
  std::map<std::uint32_t, std::uint32_t> next;  // along the cut
  for (const auto& face : solid.faces) {
    std::vector<std::uint32_t> below;
    std::uint32_t out = 0;
    std::uint32_t in = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = face[c];
      const std::uint32_t b = face[(c + 1) % 3];
      if (above[a] < 0) below.push_back(a);
      if ((above[a] < 0) == (above[b] < 0)) continue;
      const std::uint32_t x = crossing(a, b);
      below.push_back(x);
      (above[a] < 0 ? out : in) = x;
    }
    for (std::size_t c = 2; c < below.size(); ++c) {
      soup.faces.push_back({below[0], below[c - 1], below[c]});
    }
    if (below.size() > 2 && out != in) next[in] = out;
  }
  if (next.empty()) return soup;
  // A fan from one of its corners, as many programs make it.
  const std::uint32_t first = next.begin()->first;
  std::uint32_t a = next[first];
  for (std::size_t steps = 0; steps < next.size() && a != first; ++steps) {
    const auto found = next.find(a);
    if (found == next.end() || found->second == first) break;
    soup.faces.push_back({first, a, found->second});
    a = found->second;
  }
  return soup;
}

}  // namespace geodesic::bench
