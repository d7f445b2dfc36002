#include "server/places/field_rows.h"

#include <map>
#include <string>
#include <unordered_set>
#include <variant>

namespace geodesic::server {
namespace {

// The same for the same boundary and for the same faces; empty for a curve.
std::string spelling_of(const proto::PointRequest& request) {
  if (const auto* boundary = std::get_if<proto::BoundaryRequest>(&request.where)) {
    return boundary->loop ? "boundary " + std::to_string(*boundary->loop) : "boundary";
  }
  const auto* faces = std::get_if<proto::FacesRequest>(&request.where);
  return faces == nullptr ? std::string() : "faces " + faces->shape;
}

// `kept`: all of it, where that is kept. Nothing if the poll says to stop.
std::shared_ptr<const FieldRows::Outline> outline_of(const FieldSources& from,
                                                     std::shared_ptr<const FieldSources> kept,
                                                     Poll& poll) {
  FieldRows::Outline outline{std::move(kept), {}};
  if (outline.lines) return std::make_shared<const FieldRows::Outline>(std::move(outline));
  const SourceLines& lines = *from.lines;
  std::size_t count = 0;
  for (const std::uint32_t item : lines.item_of_face) {
    if (poll.cancelled()) return nullptr;
    count += item == kNone ? 0 : 1;
  }
  if (!poll.may_take(count * sizeof(std::uint32_t) + from.points.size() * sizeof(Source) +
                     lines.segments.size() * sizeof(LineSegment))) {
    return nullptr;
  }
  outline.faces.reserve(count);
  for (std::uint32_t f = 0; f < lines.item_of_face.size(); ++f) {
    if (poll.cancelled()) return nullptr;
    if (lines.item_of_face[f] != kNone) outline.faces.push_back(f);
  }
  auto border = std::make_shared<const SourceLines>(SourceLines{lines.segments, {}, {}});
  outline.lines =
      std::make_shared<const FieldSources>(FieldSources{from.points, std::move(border), from.key});
  return std::make_shared<const FieldRows::Outline>(std::move(outline));
}

}  // namespace

Result<FieldRows> FieldRows::make(std::shared_ptr<const SourceSurface> surface,
                                  std::span<const proto::PointRequest> requests,
                                  std::span<const SurfacePoint> points,
                                  std::vector<proto::ResolvedPoint>& echo, bool outlines,
                                  SolveScratch& scratch, const Cancel& cancel) {
  struct Known {
    std::shared_ptr<const FieldSources> kept;
    std::shared_ptr<const Outline> outline;
    proto::ResolvedPoint echo;
  };
  std::map<std::string, Known> known;
  FieldRows rows;
  rows.surface_ = std::move(surface);
  SourceBuilder builder(*rows.surface_, scratch, cancel);
  Poll poll(cancel);
  for (const proto::PointRequest& request : requests) {
    const auto own = points.first(count_points(request));
    points = points.subspan(own.size());
    Source& source = rows.points_.emplace_back();
    if (request.is_point()) {
      source = {own.front(), request.offset};
      continue;
    }
    if (cancel.requested()) return fail_stopped(cancel);
    Line& line = rows.lines_[rows.points_.size() - 1];
    const bool is_faces = std::holds_alternative<proto::FacesRequest>(request.where);
    if (is_faces) line.faces = request;
    const std::string spelling = spelling_of(request);
    if (const auto same = known.find(spelling); same != known.end()) {
      line.kept = same->second.kept;
      line.outline = same->second.outline;
      echo.push_back(same->second.echo);
      continue;
    }
    auto told = builder.add_lines(request, own);
    if (!told) return fail(std::move(told.error()));
    auto made = builder.take();
    if (!made) return fail(std::move(made.error()));
    if (!is_faces) line.kept = std::make_shared<const FieldSources>(std::move(*made));
    if (outlines) {
      line.outline = outline_of(*made, line.kept, poll);
      if (poll.stopped()) return fail_stopped(poll);
    }
    if (!spelling.empty()) known.emplace(spelling, Known{line.kept, line.outline, *told});
    echo.push_back(std::move(*told));
  }
  return rows;
}

std::vector<SurfacePoint> FieldRows::points() const {
  std::vector<SurfacePoint> points;
  points.reserve(points_.size());
  for (const Source& source : points_) points.push_back(source.point);
  return points;
}

Result<FieldSources> FieldRows::of(std::size_t row, SolveScratch& scratch,
                                   const Cancel& cancel) const {
  const auto line = lines_.find(row);
  if (line == lines_.end()) return FieldSources{{points_[row]}, nullptr, {}};
  if (const auto& kept = line->second.kept) {
    if (!cancel.may_take(kept->points.size() * sizeof(Source))) return fail_stopped(cancel);
    return *kept;
  }
  SourceBuilder builder(*surface_, scratch, cancel);
  if (auto added = builder.add_lines(line->second.faces, {}); !added) {
    return fail(std::move(added.error()));
  }
  return builder.take();
}

std::size_t FieldRows::bytes() const {
  std::size_t bytes = points_.capacity() * sizeof(Source) + bytes_of_outlines();
  std::unordered_set<const FieldSources*> counted;  // rows may share them
  for (const auto& [row, line] : lines_) {
    bytes += sizeof(Line);
    if (const auto* faces = std::get_if<proto::FacesRequest>(&line.faces.where)) {
      bytes += faces->shape.capacity();
    }
    if (line.kept && counted.insert(line.kept.get()).second) bytes += line.kept->bytes();
  }
  return bytes;
}

std::size_t FieldRows::bytes_of_outlines() const {
  std::size_t bytes = 0;
  std::unordered_set<const Outline*> counted;
  for (const auto& [row, line] : lines_) {
    const Outline* outline = line.outline.get();
    if (outline == nullptr || outline->lines == line.kept) continue;
    if (counted.insert(outline).second) bytes += outline->bytes();
  }
  return bytes;
}

Result<void> FieldRows::reserve(const Caller& caller) {
  const std::size_t of_outlines = bytes_of_outlines();
  auto reserved = reserve_lines(caller, bytes() - of_outlines);
  if (!reserved) return fail(std::move(reserved.error()));
  auto outlines_reserved = reserve_lines(caller, of_outlines);
  if (!outlines_reserved) return fail(std::move(outlines_reserved.error()));
  reserved_ = std::move(*reserved);
  outlines_reserved_ = std::move(*outlines_reserved);
  return {};
}

void FieldRows::drop_outlines() {
  for (auto& [row, line] : lines_) line.outline = nullptr;
  outlines_reserved_ = nullptr;
}

}  // namespace geodesic::server
