// What is measured on a tiny mesh: discs and strips against each other, extents and means against
// the fields of all vertices, and estimated distances against the triangle inequality.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/extent/extent.h"
#include "core/extent/mean_distances.h"
#include "core/landmarks/landmark_distances.h"
#include "core/landmarks/spread_points.h"
#include "core/paths/discs.h"
#include "core/paths/strips.h"
#include "core/solve/solve_field.h"
#include "tests/fuzz/small_soup.h"

namespace geodesic::fuzz {
namespace {

constexpr double kRounding = 1e-7;  // relative
constexpr double kOfSize = 1e-9;
constexpr std::uint64_t kAllFields = 1000;  // more than a tiny mesh has vertices
constexpr std::size_t kLandmarks = 8;
constexpr double kFloats = 3e-6;  // of the greatest distance: bounds of estimates are floats

bool is_near(double a, double b, double slack) {
  return std::abs(a - b) <= kRounding * std::max(std::abs(a), std::abs(b)) + slack;
}

bool is_reached(const FaceRecord& face, const Field& field) {
  return std::all_of(face.vertex.begin(), face.vertex.end(),
                     [&](auto v) { return field.distance[v] != kUnreached; });
}

// The area of faces that the field reaches.
double area_reached(const Adjacency& adjacency, const Field& field) {
  double area = 0;
  for (const FaceRecord& face : adjacency.faces()) {
    if (is_reached(face, field)) area += face.area2 / 2;
  }
  return area;
}

void check_discs(const Adjacency& adjacency, const Field& field, double farthest, double size) {
  std::vector<double> radii;
  for (int i = 1; i <= 4; ++i) radii.push_back(farthest * i / 4);
  if (!(radii.front() > 0)) return;
  const double slack = kOfSize * size * size;
  const auto discs = measure_discs(adjacency, field, radii, Cancel());
  expect(discs.has_value(), "every field has discs");
  std::vector<double> levels{0};
  levels.insert(levels.end(), radii.begin(), radii.end());
  const auto strips = cut_strips(adjacency, field, levels, Cancel());
  expect(strips && strips->size() == radii.size(), "and strips between them");
  double before = 0;
  double faces = 0;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const Disc& disc = discs->discs[i];
    expect(std::isfinite(disc.perimeter) && disc.perimeter >= 0, "a perimeter is a length");
    expect(disc.area >= before * (1 - kRounding) - slack, "a larger disc has more area");
    expect(disc.mean >= 0 && disc.mean <= disc.radius * (1 + kRounding), "a mean is within");
    const Strip& strip = (*strips)[i];
    expect(is_near(strip.area, disc.area - before, 10 * slack), "a strip is between two discs");
    before = disc.area;
    faces += static_cast<double>(strip.faces.size());
    for (const auto& face : strip.faces) {
      for (const std::uint32_t v : face) {
        expect(v < strip.positions.size(), "a strip's faces have its vertices");
      }
    }
  }
  const bool is_all = std::all_of(adjacency.faces().begin(), adjacency.faces().end(),
                                  [&](const FaceRecord& face) { return is_reached(face, field); });
  expect(discs->discs.back().is_whole == is_all, "the last disc has all, if the field has");
  expect(is_near(before, area_reached(adjacency, field), slack), "and all of the area");
  expect(faces <=
             static_cast<double>(most_faces_of_strips(adjacency.faces().size(), discs->crossings)) +
                 4.0 * static_cast<double>(adjacency.faces().size()),
         "strips have no more faces than said");
}

using Rows = std::vector<std::vector<double>>;

// Over the part with the most vertices.
void check_extents(const Adjacency& adjacency, const Rows& rows, double size) {
  const double slack = kOfSize * size;
  SolveScratch scratch;
  for (const std::uint64_t fields : {std::uint64_t{3}, kAllFields}) {
    const auto diameter =
        extent(ExtentOf::diameter, Method::exact, {}, adjacency, fields, scratch, Cancel());
    const auto center =
        extent(ExtentOf::center, Method::exact, {}, adjacency, fields, scratch, Cancel());
    expect(diameter && center, "every surface has an extent");
    expect(diameter->vertices.size() == 2 && center->vertices.size() == 1, "with its vertices");
    const std::uint32_t within = center->vertices[0];
    // The oracle: all rows of the vertices that this one reaches.
    double longest = 0;
    double least = kUnreached;
    for (std::uint32_t v = 0; v < rows.size(); ++v) {
      if (rows[within][v] == kUnreached) continue;
      double farthest = 0;
      for (const double d : rows[v]) {
        if (d != kUnreached) farthest = std::max(farthest, d);
      }
      longest = std::max(longest, farthest);
      least = std::min(least, farthest);
    }
    expect(diameter->lower <= longest * (1 + kRounding) + slack &&
               diameter->upper >= longest * (1 - kRounding) - slack,
           "the diameter is within its bounds");
    expect(center->lower <= least * (1 + kRounding) + slack &&
               center->upper >= least * (1 - kRounding) - slack,
           "so is the radius");
    if (fields == kAllFields) {
      expect(diameter->is_exact && is_near(diameter->value, longest, slack),
             "all fields are exact");
      expect(center->is_exact && is_near(center->value, least, slack), "for the center as well");
    }
    const auto means = mean_distances(Method::exact, {}, adjacency, fields, scratch, Cancel());
    expect(means.has_value(), "every surface has means");
    for (std::uint32_t v = 0; v < rows.size(); ++v) {
      const double mean = means->mean[v];
      expect(!std::isnan(mean) && mean >= 0, "a mean is not negative");
      if (mean != kUnreached) expect(mean <= longest * (1 + kRounding) + slack, "nor too great");
    }
    expect(means->lower <= means->overall + slack && means->overall <= means->upper + slack,
           "the mean is within its bounds");
  }
}

void check_estimates(const Adjacency& adjacency, const Rows& rows) {
  std::vector<SurfacePoint> points;
  for (std::uint32_t v = 0; v < rows.size(); ++v) {
    points.push_back(point_at_vertex(adjacency, v));
  }
  const auto landmarks = spread_points(adjacency, points, kLandmarks, Cancel());
  expect(landmarks && !landmarks->empty() && landmarks->size() <= kLandmarks,
         "some points are spread");
  Rows known;
  for (const std::uint32_t landmark : *landmarks) known.push_back(rows[landmark]);
  const auto distances = LandmarkDistances::make(*landmarks, known, Cancel());
  expect(distances.has_value(), "every set of landmarks is one");
  double greatest = 0;
  for (const auto& row : rows) {
    for (const double d : row) {
      if (d != kUnreached) greatest = std::max(greatest, d);
    }
  }
  const double slack = kFloats * greatest;
  const Cancel never;
  Poll poll(never);
  for (std::uint32_t from = 0; from < rows.size(); ++from) {
    std::vector<double> to_landmarks;
    for (const auto& row : known) to_landmarks.push_back(row[from]);
    const double near = distances->near(to_landmarks);
    std::vector<double> row = rows[from];
    for (double& d : row) {
      if (d > near) d = kUnreached;
    }
    distances->estimate(to_landmarks, row, poll);
    for (std::uint32_t to = 0; to < rows.size(); ++to) {
      const double d = row[to];
      expect(!std::isnan(d) && d >= 0, "an estimate is a distance");
      expect((d == kUnreached) == (rows[from][to] == kUnreached), "where there is a way");
      if (d == kUnreached) continue;
      double least = 0;
      double most = kUnreached;
      for (std::size_t i = 0; i < known.size(); ++i) {
        if (to_landmarks[i] == kUnreached || known[i][to] == kUnreached) continue;
        least = std::max(least, std::abs(to_landmarks[i] - known[i][to]));
        most = std::min(most, to_landmarks[i] + known[i][to]);
      }
      expect(d >= least - slack, "no less than the triangle allows");
      if (rows[from][to] > near) {
        expect(d <= most + slack, "nor more");
      }
    }
  }
}

}  // namespace

void fuzz_measures(Input input) {
  Reader reader(input);
  const std::uint8_t which = reader.byte();
  const auto mesh = small_mesh(reader);
  if (mesh == nullptr) return;
  const Adjacency adjacency = Adjacency::build(mesh);
  const double size = distance(mesh->box().min, mesh->box().max);
  SolveScratch scratch;
  Rows rows;
  for (std::uint32_t v = 0; v < mesh->vertex_count(); ++v) {
    const Source source{point_at_vertex(adjacency, v), 0};
    auto field = solve_field(Method::exact, {}, adjacency, {&source, 1}, {}, scratch, Cancel());
    expect(field.has_value(), "every mesh has a field");
    if (v == which % mesh->vertex_count()) check_discs(adjacency, *field, field->max, size);
    std::vector<double>& row = rows.emplace_back();
    for (std::uint32_t to = 0; to < mesh->vertex_count(); ++to) row.push_back(field->distance[to]);
  }
  check_extents(adjacency, rows, size);
  check_estimates(adjacency, rows);
}

}  // namespace geodesic::fuzz
