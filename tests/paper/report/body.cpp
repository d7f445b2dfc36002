// Fig. 8 of Tang et al. 2007: the field of a horse from the top of its nose.
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/picture/picture.h"
#include "tests/bench/errors.h"
#include "tests/bench/prepared.h"
#include "tests/paper/report/generated_body.h"
#include "tests/paper/report/report.h"
#include "tests/paper/report/report_files.h"

namespace geodesic::report {
namespace {

using bench::Prepared;

struct Body {
  std::string_view name;
  TriangleSoup soup;  // y is up, it faces -x
};

Body body_at_hand(bench::Scale scale) {
  if (scale == bench::Scale::full) {
    if (auto horse = bench::scanned_subject("horse")) {
      // The scan's z is up; it faces y and looks to the side of -x.
      for (Vec3& p : horse->soup.positions) p = {-p.y, p.z, -p.x};
      return {"horse", std::move(horse->soup)};
    }
    return {"generated", generated_body(150)};
  }
  return {"generated", generated_body(40)};
}

std::uint32_t farthest_along(const TriangleSoup& soup, Vec3 direction) {
  std::uint32_t farthest = 0;
  for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
    if (dot(soup.positions[v], direction) > dot(soup.positions[farthest], direction)) farthest = v;
  }
  return farthest;
}

}  // namespace

void body(const Setting& setting) {
  const Body body = body_at_hand(setting.scale);
  const Prepared prepared(body.soup);
  const std::uint32_t nose = farthest_along(body.soup, {-0.4, 0.45, 0.8});
  const Field field = prepared.solve(Method::wavefront, nose);
  const Field truth = prepared.solve(Method::exact, nose);
  const bench::Errors errors = bench::errors_of(field.distance.values(), truth.distance.values());

  const std::vector<double> distances = field.distance.values();  // the picture looks at them
  proto::PictureContent content;
  content.values = distances;
  content.sources = {body.soup.positions[nose]};
  Table table(setting.folder / "fig8.csv",
              {"body", "vertices", "to", "distance", "path_length", "true_distance", "mean_error",
               "max_error", "greatest_distance"});
  const std::pair<const char*, Vec3> ends[] = {{"fore hoof", {-0.5, -1, 0.5}},
                                               {"hind hoof", {0.9, -1, 0.5}},
                                               {"tail", {1, 0.4, 0}},
                                               {"ear", {0.15, 1, 0.55}}};
  for (const auto& [to, direction] : ends) {
    std::uint32_t end = farthest_along(body.soup, direction);
    const Path path = prepared.path(field, end);
    const std::uint32_t v = prepared.vertex(end);
    table.row({body.name, body.soup.positions.size(), to, field.distance[v], path.length,
               truth.distance[v], errors.mean, errors.max, field.max});
    content.targets.push_back(body.soup.positions[end]);
    content.lines.emplace_back();
    for (const PathPoint& point : path.points) content.lines.back().push_back(point.position);
  }

  proto::PictureOptions options;
  options.width = 1310;  // of which the scale, which draw_figures.py cuts off, takes 110
  options.height = 1100;
  options.view = proto::View{12, 10};
  options.stripes = 40;
  const auto image = proto::draw_picture(prepared.mesh(), content, options, Cancel());
  if (!image) bench::give_up("Fig. 8: " + image.error().detail);
  const std::string png = proto::encode_png(*image);
  std::ofstream(setting.arrays / "fig8.png", std::ios::binary) << png;
}

}  // namespace geodesic::report
