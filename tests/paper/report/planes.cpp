// Figs. 5, 6 and 7 of Tang et al. 2007: planes, whole and with square holes.
#include <cmath>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/wire/methods.h"
#include "tests/bench/errors.h"
#include "tests/bench/prepared.h"
#include "tests/paper/report/report.h"
#include "tests/paper/report/report_files.h"

namespace geodesic::report {

using bench::Errors;
using bench::errors_of;
using bench::Prepared;
using bench::Subject;
using proto::name_of;
using shapes::Diagonal;

void plane(const Setting& setting) {
  const std::uint32_t side = bench::holes_of_the_paper(setting.scale).side;
  Table table(setting.folder / "fig5.csv",
              {"method", "diagonals", "vertices", "max_error", "mean_square_error", "rms_error",
               "mean_relative_error", "max_relative_error"});
  for (const auto diagonal : {Diagonal::rising, Diagonal::falling}) {
    // "The edge length of the rectangle is 1", so that the paper's figures compare.
    TriangleSoup soup = shapes::plane(side, side, diagonal);
    for (Vec3& p : soup.positions) p = {p.x / (side - 1), p.y / (side - 1), 0};
    std::vector<double> truth;
    for (const Vec3& p : soup.positions) truth.push_back(norm(p));
    const Prepared prepared(soup);
    const bool rising = diagonal == Diagonal::rising;
    for (const Method method : setting.methods) {
      const auto distance = prepared.in_source_order(prepared.solve(method).distance.values());
      const Errors e = errors_of(distance, truth);
      table.row({name_of(method), rising ? "rising" : "falling", soup.positions.size(),
                 e.max_absolute, e.mean_square, std::sqrt(e.mean_square), e.mean, e.max});
      if (method != Method::wavefront || !rising) continue;
      write_surface(setting.arrays, "fig5", soup);
      write_values(setting.arrays, "fig5.distance", distance);
      write_isolines(setting.arrays, "fig5", prepared.adjacency(), prepared.solve(method));
      std::vector<double> error(distance.size());
      for (std::size_t v = 0; v < error.size(); ++v) error[v] = distance[v] - truth[v];
      write_values(setting.arrays, "fig5.error", error);
    }
  }
}

void planes_with_holes(const Setting& setting) {
  const bench::Holes holes = bench::holes_of_the_paper(setting.scale);
  const struct {
    const char* name;
    const std::vector<shapes::Hole>& holes;
  } figures[] = {{"fig6", holes.one}, {"fig7a", holes.two}, {"fig7b", holes.three}};
  const std::uint32_t top_right = holes.side * holes.side - 1;
  Table table(setting.folder / "holes.csv",
              {"figure", "diagonals", "method", "true_distance", "distance", "distance_error",
               "path_length", "path_error", "passes"});
  for (const auto& figure : figures) {
    for (const auto diagonal : {Diagonal::rising, Diagonal::falling}) {
      const bool rising = diagonal == Diagonal::rising;
      const Subject subject =
          bench::plane_among_holes(figure.name, "", holes.side, figure.holes, diagonal);
      const Prepared prepared(subject.soup);
      const double truth = subject.known[top_right];
      for (const Method method : setting.methods) {
        const Field field = prepared.solve(method);
        const double distance = field.distance[prepared.vertex(top_right)];
        const Path path = prepared.path(field, top_right);
        // Below the diagonal through both corners where the path is farthest from it.
        double farthest = 0;
        for (const PathPoint& point : path.points) {
          const double above = point.position.y - point.position.x;
          if (std::abs(above) > std::abs(farthest)) farthest = above;
        }
        table.row({figure.name, rising ? "rising" : "falling", name_of(method), truth, distance,
                   distance / truth - 1, path.length, path.length / truth - 1,
                   farthest < 0 ? "below" : "above"});
        if (method != Method::wavefront || !rising) continue;
        write_surface(setting.arrays, figure.name, subject.soup);
        write_values(setting.arrays, std::string(figure.name) + ".distance",
                     prepared.in_source_order(field.distance.values()));
        write_isolines(setting.arrays, figure.name, prepared.adjacency(), field);
        write_path(setting.folder, std::string(figure.name) + "_path", path);
      }
    }
  }
}

}  // namespace geodesic::report
