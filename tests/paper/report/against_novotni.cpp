// Where Novotni and Klein's rule and that of Tang et al. differ: the two cases of
// Fig. 4 (b) and (c), where the line to the virtual source misses the base.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "core/wavefront/novotni.h"
#include "core/wavefront/virtual_source.h"
#include "tests/bench/errors.h"
#include "tests/bench/prepared.h"
#include "tests/paper/report/report.h"
#include "tests/paper/report/report_files.h"

namespace geodesic::report {
namespace {

using bench::Errors;
using bench::Prepared;

std::vector<double> signed_errors(std::span<const double> distance, std::span<const double> truth) {
  std::vector<double> errors(truth.size());
  for (std::size_t v = 0; v < errors.size(); ++v) {
    errors[v] = truth[v] > 0 ? distance[v] / truth[v] - 1 : 0;
  }
  return errors;
}

// Whether a vertex's distance came by one of the two cases, past an end of the base
// between its parents, and Novotni and Klein's rule has another for it.
bool is_bent(const Adjacency& adjacency, const Field& field, std::uint32_t v) {
  const auto [p, q] = field.parents[v];
  if (p == kNone || q == kNone) return false;
  for (const std::uint32_t corner : adjacency.corners(v)) {
    const FaceRecord& face = adjacency.face(face_of(corner));
    const std::uint32_t base = next_corner(corner_of(corner));
    const std::uint32_t from = face.vertex[base];
    const std::uint32_t to = face.vertex[next_corner(base)];
    if (!(from == p && to == q) && !(from == q && to == p)) continue;
    const Arrival arrival = arrive(field.distance[from], field.distance[to], face.apex_over(base));
    // The base may have been taken from its other end, which rounds otherwise.
    if (arrival.distance > field.distance[v] * (1 + 1e-12)) continue;
    const Arrival straight =
        arrive_without_cases(field.distance[from], field.distance[to], face.apex_over(base));
    return arrival.which != Fig4::a &&
           arrival.distance - straight.distance > Errors::kRounding * arrival.distance;
  }
  return false;
}

}  // namespace

void against_novotni(const Setting& setting, std::span<const bench::Subject> subjects) {
  const std::set<std::string> with_map{"plane_three_holes", "terrain"};
  Table table(setting.folder / "novotni.csv",
              {"mesh", "title", "vertices", "share_bent", "share_different", "mean_difference",
               "max_difference", "novotni_mean", "novotni_max", "novotni_below", "novotni_lowest",
               "ours_mean", "ours_max", "ours_below", "ours_lowest"});
  for (const bench::Subject& subject : subjects) {
    const Prepared prepared(subject.soup);
    const auto truth = prepared.solve(Method::exact).distance.values();
    const Field ours = prepared.solve(Method::wavefront);
    const Field theirs = prepared.solve(Method::novotni);
    std::vector<double> is_bent_at(truth.size(), 0);
    std::size_t bent = 0;
    std::size_t different = 0;
    std::size_t compared = 0;
    double sum = 0;
    double most = 0;
    for (std::uint32_t v = 0; v < truth.size(); ++v) {
      if (!std::isfinite(truth[v]) || !(truth[v] > 0)) continue;
      ++compared;
      if (is_bent(prepared.adjacency(), ours, v)) {
        is_bent_at[v] = 1;
        ++bent;
      }
      const double difference = std::abs(ours.distance[v] - theirs.distance[v]) / truth[v];
      if (difference > Errors::kRounding) ++different;
      sum += difference;
      most = std::max(most, difference);
    }
    const auto count = static_cast<double>(compared);
    const Errors n = bench::errors_of(theirs.distance.values(), truth);
    const Errors w = bench::errors_of(ours.distance.values(), truth);
    const auto n_signed = signed_errors(theirs.distance.values(), truth);
    const auto w_signed = signed_errors(ours.distance.values(), truth);
    table.row({subject.name, subject.title, compared, static_cast<double>(bent) / count,
               static_cast<double>(different) / count, sum / count, most, n.mean, n.max,
               n.share_below, *std::min_element(n_signed.begin(), n_signed.end()), w.mean, w.max,
               w.share_below, *std::min_element(w_signed.begin(), w_signed.end())});
    if (!with_map.contains(subject.name)) continue;
    const std::string name = "novotni." + subject.name;
    write_surface(setting.arrays, name, subject.soup);
    write_values(setting.arrays, name + ".theirs", prepared.in_source_order(n_signed));
    write_values(setting.arrays, name + ".ours", prepared.in_source_order(w_signed));
    write_values(setting.arrays, name + ".bent", prepared.in_source_order(is_bent_at));
  }
}

}  // namespace geodesic::report
