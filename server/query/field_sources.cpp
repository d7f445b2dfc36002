// What fields start from: from points, curves, boundaries and faces as clients name them to points,
// lines and faces of the mesh.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/curves/source_lines.h"
#include "core/solve/curve_lines.h"
#include "proto/mesh/metadata.h"
#include "proto/region/cut_regions.h"
#include "proto/region/read_regions.h"
#include "proto/wire/query_limits.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

using CurvePointer = std::shared_ptr<const proto::CurveRequest>;

const proto::CurveRequest* curve_in(const proto::PointRequest& request) {
  const auto* curve = std::get_if<CurvePointer>(&request.where);
  return curve == nullptr ? nullptr : curve->get();
}

bool is_all_points(const std::vector<proto::PointRequest>& requests) {
  return std::all_of(requests.begin(), requests.end(),
                     [](const proto::PointRequest& request) { return request.is_point(); });
}

// The points in all of them, in this order.
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

// That of a request of faces.
Result<proto::Shape> shape_in(const proto::PointRequest& request) {
  return proto::parse_json_shape(
      nlohmann::json::parse(std::get<proto::FacesRequest>(request.where).shape), request.parameter);
}

}  // namespace

// Adds one thing after the other to what a field starts from. In a compute slot.
class FieldQueries::Place::LineBuilder {
 public:
  LineBuilder(const Place& place, const Mesh* whole, const std::vector<SurfacePoint>& points,
              const std::vector<proto::ResolvedPoint>& echoes, const proto::FileFaces& file,
              SolveScratch& scratch, SurfacePolyline* round, const Cancel& cancel)
      : place_(place),
        whole_(whole),
        adjacency_(*place.adjacency()),
        points_(points),
        echoes_(echoes),
        file_(file),
        scratch_(scratch),
        round_(round),
        cancel_(cancel),
        poll_(cancel) {}

  Result<void> add(const proto::PointRequest& request, std::vector<proto::ResolvedPoint>& echo) {
    if (request.is_point()) {
      sources_.push_back({points_[next_], request.offset});
      lines_.item_of_source.push_back(item_++);
      echo.push_back(echoes_[next_++]);
      return {};
    }
    const std::size_t first_source = sources_.size();
    const std::size_t first_segment = lines_.segments.size();
    proto::ResolvedLines made;
    auto added = curve_in(request) != nullptr ? add_curve_of(request, made)
                 : std::holds_alternative<proto::BoundaryRequest>(request.where)
                     ? add_boundary(request, made)
                     : add_faces_of(request, made);
    if (!added) return added;
    if (poll_.stopped()) return fail_stopped(poll_);
    made.pieces = lines_.segments.size() - first_segment;
    proto::ResolvedPoint& point = echo.emplace_back(place_.told(sources_[first_source].point));
    point.lines = made;
    ++item_;
    return {};
  }

  Result<FieldSources> take() {
    merge_repeated(adjacency_, lines_, sources_, poll_);
    if (poll_.stopped()) return fail_stopped(poll_);
    FieldSources from{std::move(sources_), {}, {}};
    from.lines = std::make_shared<const SourceLines>(std::move(lines_));
    from.key = key_of_lines(from, poll_);
    if (poll_.stopped()) return fail_stopped(poll_);
    return from;
  }

 private:
  Result<void> add_curve_of(const proto::PointRequest& request, proto::ResolvedLines& made) {
    const proto::CurveRequest& curve = *curve_in(request);
    const std::size_t first = sources_.size();
    const std::vector<SurfacePoint> points(
        points_.begin() + static_cast<std::ptrdiff_t>(next_),
        points_.begin() + static_cast<std::ptrdiff_t>(next_ + curve.points.size()));
    next_ += curve.points.size();
    const auto length = add_curve(adjacency_, points, curve.is_closed, item_,
                                  proto::kMaxCurvePieces, lines_, sources_, scratch_, cancel_);
    if (!length) {
      Error error = length.error();
      if (error.code == ErrorCode::no_loop) {
        error.parameter = curve.points[error.actual.value_or(0)].parameter;
        error.actual.reset();
      } else if (error.code == ErrorCode::too_large && error.parameter.empty()) {
        error.parameter = request.parameter;
      }
      return fail(std::move(error));
    }
    made.kind = "curve";
    made.length = *length;
    if (round_ == nullptr || !curve.is_closed) return {};
    round_->clear();
    if (!poll_.may_take((sources_.size() - first) * sizeof(SurfacePoint))) {
      return fail_stopped(poll_);
    }
    for (std::size_t i = first; i < sources_.size(); ++i) round_->push_back(sources_[i].point);
    return {};
  }

  Result<void> add_boundary(const proto::PointRequest& request, proto::ResolvedLines& made) {
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

  Result<void> add_faces_of(const proto::PointRequest& request, proto::ResolvedLines& made) {
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
    const auto marked = proto::faces_of_shape(*whole_, *shape, file_, cancel_);
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

  const Place& place_;
  const Mesh* whole_;  // of the file; not null if faces are named
  const Adjacency& adjacency_;
  const std::vector<SurfacePoint>& points_;
  const std::vector<proto::ResolvedPoint>& echoes_;
  const proto::FileFaces& file_;
  SolveScratch& scratch_;
  SurfacePolyline* const round_;
  const Cancel& cancel_;
  Poll poll_;
  std::vector<Source> sources_;
  SourceLines lines_;
  std::vector<BoundaryLoop> loops_;
  std::size_t next_ = 0;  // of the points
  std::uint32_t item_ = 0;
  std::uint64_t ranges_ = 0;
};

Result<FieldSources> FieldQueries::Place::sources(const std::vector<proto::PointRequest>& requests,
                                                  std::vector<proto::ResolvedPoint>& echo,
                                                  std::vector<std::string>& warnings,
                                                  SurfacePolyline* round) const {
  const bool is_points = is_all_points(requests);
  std::vector<proto::ResolvedPoint> echoes;
  const auto found =
      is_points ? points(requests, echo, warnings) : points(points_in(requests), echoes, warnings);
  if (!found) return fail(found.error());
  if (is_points) {
    FieldSources from;
    from.points.reserve(found->size());
    for (std::size_t i = 0; i < found->size(); ++i) {
      from.points.push_back({(*found)[i], requests[i].offset});
    }
    return from;
  }
  proto::FileFaces file;
  std::shared_ptr<const Adjacency> whole;  // shapes are by its faces, whatever walls have split
  bool has_faces = false;
  proto::NamedOfFile named;
  for (const proto::PointRequest& request : requests) {
    if (!std::holds_alternative<proto::FacesRequest>(request.where)) continue;
    const auto shape = shape_in(request);
    if (!shape) return fail(shape.error());
    has_faces = true;
    named.add(*shape);
  }
  if (has_faces) {
    auto told = queries_.catalog_.file_faces(surface_.mesh(), named, caller_.part(0, 0));
    if (!told) return fail(std::move(told.error()));
    file = std::move(*told);
    auto prepared = queries_.catalog_.adjacency(surface_.mesh(), caller_.part(0, 0));
    if (!prepared) return fail(std::move(prepared.error()));
    whole = std::move(*prepared);
  }
  return queries_.fields_.compute(
      [&](SolveScratch& scratch, const Cancel& cancel) -> Result<FieldSources> {
        echo.clear();  // it may be run again
        LineBuilder builder(*this, whole != nullptr ? &whole->mesh() : nullptr, *found, echoes,
                            file, scratch, round, cancel);
        for (const proto::PointRequest& request : requests) {
          if (auto added = builder.add(request, echo); !added) return fail(added.error());
        }
        return builder.take();
      },
      caller_.part(0, 0));
}

}  // namespace geodesic::server
