#include "server/places/walled_surface.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/refine/faces_inside.h"
#include "core/solve/pair_search.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/line_gaps.h"
#include "core/surface/refined_surface.h"
#include "proto/wire/query_limits.h"
#include "server/places/resolve_point.h"

namespace geodesic::server {
namespace {

using Requests = std::vector<proto::PointRequest>;

bool any_searched(const Requests& points) {
  return std::any_of(points.begin(), points.end(), is_searched);
}

bool any_searched_in(const std::vector<proto::Shape>& region) {
  return std::any_of(region.begin(), region.end(), [](const proto::Shape& shape) {
    const auto* inside = std::get_if<proto::InsideShape>(&shape.what);
    return inside != nullptr && any_searched(inside->points);
  });
}

// Of a point in a list that is read and in a line that grows, which doubles.
constexpr std::uint64_t kBytesOfPoint = 3 * sizeof(SurfacePoint);

// The lines of a query on the whole surface.
class LineFinder {
 public:
  LineFinder(const Adjacency& whole, const ClosestPointIndex* index, const Cancel& cancel)
      : whole_(whole), index_(index), cancel_(cancel), poll_(cancel) {}

  // From point to point; with `is_round` back to the first.
  Result<SurfacePolyline> line(const Requests& requests, bool is_round) {
    if (!poll_.may_take(kBytesOfPoint * (requests.size() + 1))) return fail_stopped(poll_);
    std::vector<SurfacePoint> points;
    points.reserve(requests.size() + 1);
    for (const proto::PointRequest& request : requests) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      auto placed = resolve_point(whole_, nullptr, index_, request, cancel_);
      if (!placed) return fail(std::move(placed.error()));
      points.push_back(placed->point);
    }
    if (is_round) points.push_back(points.front());
    SurfacePolyline line{points.front()};
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (is_same_place(points[i - 1], points[i])) continue;
      if (auto led = lead_to(points[i], line); !led) return fail(std::move(led.error()));
      if (!is_same_place(line.back(), points[i])) {
        return fail(ErrorCode::value_out_of_range,
                    "no way leads from this point of the line to the next one",
                    requests[i - 1].parameter);
      }
    }
    return line;
  }

 private:
  // Goes on with a line, unless there is no way.
  Result<void> lead_to(const SurfacePoint& next, SurfacePolyline& line) {
    const std::uint32_t face = face_in_common(whole_, line.back(), next, poll_);
    if (poll_.stopped()) return fail_stopped(poll_);
    if (face != kNone) {
      line.push_back(next);
      return {};
    }
    auto pair = pair_search(Method::exact, {}, whole_, {line.back(), 0}, next, PairPath::refined,
                            scratch_, cancel_);
    if (!pair) return fail(std::move(pair.error()));
    if (!pair->path) return {};
    const auto& points = pair->path->points;
    if (!poll_.may_take(kBytesOfPoint * points.size())) return fail_stopped(poll_);
    for (std::size_t i = 1; i + 1 < points.size(); ++i) line.push_back(points[i].point);
    line.push_back(next);
    return {};
  }

  const Adjacency& whole_;
  const ClosestPointIndex* index_;
  const Cancel& cancel_;
  Poll poll_;
  SolveScratch scratch_;
};

// Puts the lines of a query in, and takes what is left.
class LineCutter {
 public:
  LineCutter(const Adjacency& whole, const ClosestPointIndex* index, const proto::Regions& regions,
             const Cancel& cancel)
      : whole_(whole), regions_(regions), cancel_(cancel), finder_(whole, index, cancel) {}

  Result<CutMesh> cut(const proto::FileFaces& file) {
    // What is wrong with shapes is said before lines are searched for.
    auto shapes = proto::faces_of_regions(whole_.mesh(), regions_, file, cancel_);
    if (!shapes) return fail(std::move(shapes.error()));
    if (auto found = find_lines(); !found) return fail(std::move(found.error()));
    auto refined = refine_along(whole_, lines_, proto::kMaxLineVertices, cancel_);
    if (!refined) {
      Error& error = refined.error();
      if (error.code == ErrorCode::no_triangles) return fail(proto::nothing_left(regions_));
      if (error.code == ErrorCode::too_large) error.parameter = parameters_[0];
      return fail(std::move(error));
    }
    auto left = faces_left(*refined, *shapes);
    if (!left) return fail(std::move(left.error()));
    auto cut = cut_along(*refined, walls_, *left, cancel_);
    if (cut || !(cut.error().code == ErrorCode::no_triangles)) return cut;
    return fail(proto::nothing_left(regions_));
  }

 private:
  Result<void> find_lines() {
    Poll poll(cancel_);
    // A wall that is there again cuts nothing more.
    std::set<std::string> seen;
    for (const proto::Wall& wall : regions_.walls) {
      if (poll.cancelled()) return fail_stopped(poll);
      if (!seen.insert(proto::canonical_text(proto::Regions{{}, {}, {wall}})).second) continue;
      auto line = finder_.line(wall.points, false);
      if (!line) return fail(std::move(line.error()));
      walls_.push_back(static_cast<std::uint32_t>(lines_.size()));
      lines_.push_back(as_wall(whole_, *line, poll));
      parameters_.push_back(wall.parameter);
    }
    for (const auto* region : {&regions_.within, &regions_.forbid}) {
      for (const proto::Shape& shape : *region) {
        const auto* inside = std::get_if<proto::InsideShape>(&shape.what);
        if (inside == nullptr) continue;
        auto line = finder_.line(inside->points, true);
        if (!line) return fail(std::move(line.error()));
        insides_.push_back({static_cast<std::uint32_t>(lines_.size()), region == &regions_.within});
        lines_.push_back(std::move(*line));
        parameters_.push_back(shape.parameter + ".inside");
      }
    }
    if (poll.stopped()) return fail_stopped(poll);
    return {};
  }

  // By face of the refined mesh.
  Result<std::vector<std::uint8_t>> faces_left(const RefinedMesh& refined,
                                               const proto::RegionFaces& shapes) {
    Poll poll(cancel_);
    const Mesh& mesh = refined.mesh;
    if (!poll.may_take(2 * std::uint64_t{mesh.face_count()})) return fail_stopped(poll);
    std::vector<std::uint8_t> within(mesh.face_count());
    std::vector<std::uint8_t> forbid(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
      if (poll.cancelled()) return fail_stopped(poll);
      within[f] = shapes.within[mesh.source_of_face(f)];
      forbid[f] = shapes.forbid[mesh.source_of_face(f)];
    }
    if (!insides_.empty()) {
      const auto adjacency = build_unrefined(std::make_shared<const Mesh>(mesh), cancel_);
      if (!adjacency) return fail(adjacency.error());
      for (const auto& [line, is_within] : insides_) {
        auto inside = faces_inside(*adjacency, refined.chains[line], cancel_);
        if (!inside) {
          if (inside.error().code == ErrorCode::value_out_of_range) {
            inside.error().parameter = parameters_[line];
          }
          return fail(std::move(inside.error()));
        }
        std::vector<std::uint8_t>& faces = is_within ? within : forbid;
        for (std::uint32_t f = 0; f < faces.size(); ++f) {
          if (poll.cancelled()) return fail_stopped(poll);
          faces[f] |= (*inside)[f];
        }
      }
    }
    for (std::uint32_t f = 0; f < within.size(); ++f) {
      if (poll.cancelled()) return fail_stopped(poll);
      if (forbid[f] != 0) within[f] = 0;
    }
    return within;
  }

  struct Inside {
    std::uint32_t line;
    bool is_within;  // or forbidden
  };

  const Adjacency& whole_;
  const proto::Regions& regions_;
  const Cancel& cancel_;
  LineFinder finder_;
  std::vector<SurfacePolyline> lines_;
  std::vector<std::string> parameters_;  // by line
  std::vector<std::uint32_t> walls_;     // lines
  std::vector<Inside> insides_;
};

}  // namespace

bool has_searched_points(const proto::Regions& regions) {
  return any_searched_in(regions.within) || any_searched_in(regions.forbid) ||
         std::any_of(regions.walls.begin(), regions.walls.end(),
                     [](const proto::Wall& wall) { return any_searched(wall.points); });
}

Result<CutMesh> cut_lines(const Adjacency& whole, const ClosestPointIndex* index,
                          const proto::Regions& regions, const proto::FileFaces& file,
                          const Cancel& cancel) {
  return LineCutter(whole, index, regions, cancel).cut(file);
}

}  // namespace geodesic::server
