#include "server/places/field_sources.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <variant>

#include "core/solve/curve_lines.h"
#include "proto/region/cut_regions.h"
#include "proto/region/read_regions.h"
#include "proto/wire/query_limits.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/places/resolve_point.h"

namespace geodesic::server {
namespace {

using CurvePointer = std::shared_ptr<const proto::CurveRequest>;

const proto::CurveRequest* curve_in(const proto::PointRequest& request) {
  const auto* curve = std::get_if<CurvePointer>(&request.where);
  return curve == nullptr ? nullptr : curve->get();
}

// The same for the same lines, to the last bit. Of no use if the poll says to stop.
std::string key_of_lines(const FieldSources& from, Poll& poll) {
  Sha256 digest;
  std::string bytes;
  const auto add = [&](const auto& value) {
    constexpr std::size_t kAtOnce = 65'536;
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
    if (bytes.size() < kAtOnce || poll.cancelled()) return;
    digest.add(bytes);
    bytes.clear();
  };
  add(from.points.size());
  for (const Source& source : from.points) {
    add(source.point.face);
    for (const double weight : source.point.bary) add(weight);
    add(source.point.vertex);
    add(source.offset);
  }
  for (const std::uint32_t item : from.lines->item_of_source) add(item);
  add(from.lines->segments.size());
  for (const LineSegment& segment : from.lines->segments) {
    add(segment.face);
    for (const double weight : segment.from) add(weight);
    for (const double weight : segment.to) add(weight);
    add(segment.item);
  }
  for (const std::uint32_t item : from.lines->item_of_face) add(item);
  digest.add(bytes);
  return digest.hex();
}

}  // namespace

Result<std::shared_ptr<const void>> reserve_lines(const Caller& caller, std::uint64_t bytes) {
  constexpr std::uint64_t kLittle = std::uint64_t{64} << 10;
  if (!caller.reserve || bytes <= kLittle) return nullptr;
  auto reserved = caller.reserve(bytes);
  if (!reserved && reserved.error().code == ServiceCode::too_much_memory) {
    reserved.error().detail =
        "the curves, boundaries and faces of this request take more memory than the server has for "
        "replies; name fewer of them at once";
  }
  return reserved;
}

std::size_t count_points(const proto::PointRequest& request) {
  if (request.is_point()) return 1;
  const proto::CurveRequest* curve = curve_in(request);
  return curve == nullptr ? 0 : curve->points.size();
}

std::vector<proto::PointRequest> points_in(const std::vector<proto::PointRequest>& requests) {
  std::vector<proto::PointRequest> points;
  for (const proto::PointRequest& request : requests) {
    if (request.is_point()) {
      points.push_back(request);
    } else if (const proto::CurveRequest* curve = curve_in(request)) {
      points.insert(points.end(), curve->points.begin(), curve->points.end());
    }
  }
  return points;
}

bool is_all_points(std::span<const proto::PointRequest> requests) {
  return std::all_of(requests.begin(), requests.end(),
                     [](const proto::PointRequest& request) { return request.is_point(); });
}

Result<proto::Shape> shape_in(const proto::PointRequest& request) {
  return proto::parse_json_shape(
      nlohmann::json::parse(std::get<proto::FacesRequest>(request.where).shape), request.parameter);
}

void SourceBuilder::add_point(const SurfacePoint& point, double offset) {
  sources_.push_back({point, offset});
  lines_.item_of_source.push_back(item_++);
}

Result<proto::ResolvedPoint> SourceBuilder::add_lines(const proto::PointRequest& request,
                                                      std::span<const SurfacePoint> points,
                                                      SurfacePolyline* round) {
  const std::size_t first_source = sources_.size();
  const std::size_t first_segment = lines_.segments.size();
  proto::ResolvedLines made;
  auto added = curve_in(request) != nullptr ? add_curve_of(request, points, round, made)
               : std::holds_alternative<proto::BoundaryRequest>(request.where)
                   ? add_boundary(request, made)
                   : add_faces_of(request, made);
  if (!added) return fail(std::move(added.error()));
  if (poll_.stopped()) return fail_stopped(poll_);
  made.pieces = lines_.segments.size() - first_segment;
  proto::ResolvedPoint told =
      reply_point(adjacency_.mesh(), surface_.refinement.get(), sources_[first_source].point);
  told.lines = made;
  ++item_;
  return told;
}

Result<FieldSources> SourceBuilder::take() {
  merge_repeated(adjacency_, lines_, sources_, poll_);
  if (poll_.stopped()) return fail_stopped(poll_);
  FieldSources from{std::exchange(sources_, {}), {}, {}};
  from.lines = std::make_shared<const SourceLines>(std::exchange(lines_, {}));
  item_ = 0;
  from.key = key_of_lines(from, poll_);
  if (poll_.stopped()) return fail_stopped(poll_);
  return from;
}

Result<void> SourceBuilder::add_curve_of(const proto::PointRequest& request,
                                         std::span<const SurfacePoint> points,
                                         SurfacePolyline* round, proto::ResolvedLines& made) {
  const proto::CurveRequest& curve = *curve_in(request);
  const std::size_t first = sources_.size();
  const std::size_t before = lines_.segments.size();
  const std::size_t most = before + proto::kMaxCurvePieces - curve_pieces_;
  const auto length = add_curve(adjacency_, points, curve.is_closed, item_, most, lines_, sources_,
                                scratch_, cancel_);
  if (!length) {
    Error error = length.error();
    if (error.code == ErrorCode::no_loop) {
      error.parameter = curve.points[error.actual.value_or(0)].parameter;
      error.actual.reset();
    } else if (error.code == ErrorCode::too_large && error.parameter.empty()) {
      error.parameter = request.parameter;
      error.limit = proto::kMaxCurvePieces;
      error.actual = proto::kMaxCurvePieces + 1;
    }
    return fail(std::move(error));
  }
  curve_pieces_ += lines_.segments.size() - before;
  made.kind = "curve";
  made.length = *length;
  if (round == nullptr || !curve.is_closed) return {};
  round->clear();
  if (!poll_.may_take((sources_.size() - first) * sizeof(SurfacePoint))) {
    return fail_stopped(poll_);
  }
  for (std::size_t i = first; i < sources_.size(); ++i) round->push_back(sources_[i].point);
  return {};
}

Result<void> SourceBuilder::add_boundary(const proto::PointRequest& request,
                                         proto::ResolvedLines& made) {
  if (loops_.empty()) loops_ = boundary_loops(adjacency_, poll_);
  if (poll_.stopped()) return fail_stopped(poll_);
  if (loops_.empty()) {
    return fail(ErrorCode::value_out_of_range, "the surface has no boundary", request.parameter);
  }
  const auto& asked = std::get<proto::BoundaryRequest>(request.where).loop;
  if (asked && *asked >= loops_.size()) {
    return fail_limit(ErrorCode::index_out_of_range, "the boundary has no such loop",
                      loops_.size() - 1, *asked, request.parameter);
  }
  made.kind = "boundary";
  for (std::size_t i = asked.value_or(0); i < (asked ? *asked + 1 : loops_.size()); ++i) {
    add_edges(adjacency_, loops_[i].edges, item_, lines_, sources_, poll_);
    if (poll_.stopped()) return fail_stopped(poll_);
    made.length += loops_[i].length;
  }
  return {};
}

Result<void> SourceBuilder::add_faces_of(const proto::PointRequest& request,
                                         proto::ResolvedLines& made) {
  const auto shape = shape_in(request);
  if (!shape) return fail(shape.error());
  if (const auto* ranges = std::get_if<std::vector<proto::FaceRange>>(&shape->what)) {
    ranges_ += ranges->size();
    if (ranges_ > proto::kMaxFaceRanges) {
      return fail_limit(ErrorCode::too_large,
                        "too many faces and ranges of them in one request; write what lies side "
                        "by side as one range",
                        proto::kMaxFaceRanges, ranges_, request.parameter);
    }
  }
  const Mesh& mesh = adjacency_.mesh();
  const auto marked = proto::faces_of_shape(surface_.whole->mesh(), *shape, surface_.file, cancel_);
  if (!marked) return fail(marked.error());
  std::vector<std::uint32_t> faces;
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    if (poll_.cancelled()) return fail_stopped(poll_);
    if ((*marked)[mesh.source_of_face(f)] != 0) faces.push_back(f);
  }
  if (faces.empty()) {
    return fail(ErrorCode::value_out_of_range, "no face of the surface is in this",
                request.parameter);
  }
  const std::size_t first = lines_.segments.size();
  add_faces(adjacency_, faces, item_, lines_, sources_, poll_);
  if (poll_.stopped()) return fail_stopped(poll_);
  const auto positions = mesh.positions();
  for (std::size_t s = first; s < lines_.segments.size(); ++s) {
    const Halfedge h = lines_.segments[s].along();
    made.length += distance(positions[adjacency_.tail(h)], positions[adjacency_.head(h)]);
  }
  made.kind = "faces";
  made.faces = faces.size();
  return {};
}

}  // namespace geodesic::server
