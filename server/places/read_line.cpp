#include "server/places/read_line.h"

#include <algorithm>

#include "core/curves/least_on_lines.h"
#include "core/field/around_points.h"
#include "core/solve/distance_at_point.h"

namespace geodesic::server {

Result<AskedOfLine> asked_of(const Adjacency& adjacency, LineColumns& lines, std::size_t number,
                             const Cancel& cancel) {
  const LineColumns::Line& line = lines.lines()[number];
  Poll poll(cancel);
  AskedOfLine asked;
  std::vector<SurfacePoint> points;
  for (const std::uint32_t row : lines.point_rows()) {
    if (line.columns.empty()) break;
    const SurfacePoint& point = lines.point(row);
    (point.at_vertex() ? asked.at_vertices : asked.in_faces).push_back(row);
    if (!point.at_vertex()) points.push_back(point);
  }
  for (std::size_t other = number; other < lines.lines().size(); ++other) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (!lines.is_told_by(number, other)) continue;
    if (other == number) {
      lines.put(line, line, 0);
      continue;
    }
    asked.others.push_back(&lines.lines()[other]);
    const FieldSources& outline = *asked.others.back()->outline->lines;
    if (!poll.may_take(4 * outline.lines->segments.size() * sizeof(std::uint32_t) +
                       outline.points.size() * sizeof(SurfacePoint))) {
      return fail_stopped(poll);
    }
    const auto around = faces_of_lines(adjacency, outline.lines->segments, poll);
    asked.faces.insert(asked.faces.end(), around.begin(), around.end());
    for (const Source& end : outline.points) points.push_back(end.point);
  }
  if (asked.in_faces.empty() && asked.others.empty()) return asked;
  const auto around = faces_around(adjacency, points, cancel);
  if (!around) return fail(around.error());
  asked.faces.insert(asked.faces.end(), around->begin(), around->end());
  if (asked.faces.empty()) asked.faces.push_back(0);  // without any, all would be kept
  std::sort(asked.faces.begin(), asked.faces.end());
  asked.faces.erase(std::unique(asked.faces.begin(), asked.faces.end()), asked.faces.end());
  if (poll.stopped()) return fail_stopped(poll);
  return asked;
}

Result<void> put_within(const Adjacency& adjacency, const Field& field, double max,
                        const AskedOfLine& asked, const LineColumns::Line& line, LineColumns& lines,
                        const Cancel& cancel) {
  Poll poll(cancel);
  const PointArrivals arrivals(adjacency, field, &poll);
  for (const std::uint32_t row : asked.in_faces) {
    const auto found = distance_at_point(adjacency, field, arrivals, lines.point(row), cancel);
    if (!found) return fail(found.error());
    lines.put(line, row, within(max, *found));
  }
  const FieldOnLines on_lines(adjacency, field, poll);
  for (const LineColumns::Line* other : asked.others) {
    const FieldSources& outline = *other->outline->lines;
    double least = on_lines.meets(other->outline->faces) ? 0 : kUnreached;
    if (least > 0) least = on_lines.least(outline.lines->segments);
    for (const Source& end : outline.points) {
      if (least == 0 || poll.cancelled()) break;
      const auto found = distance_at_point(adjacency, field, arrivals, end.point, cancel);
      if (!found) return fail(found.error());
      least = std::min(least, *found);
    }
    if (poll.stopped()) return fail_stopped(poll);
    lines.put(line, *other, within(max, least));
  }
  return {};
}

}  // namespace geodesic::server
