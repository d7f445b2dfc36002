#include "proto/region/cut_regions.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/polled_fill.h"
#include "core/mesh/cut_mesh.h"

namespace geodesic::proto {
namespace {

// By source face, not 0 for those that are left.
using Faces = std::vector<std::uint8_t>;

// The mean of a face's corners; the source face may have been dropped.
Vec3 centroid_of(const Mesh& mesh, std::uint32_t source) {
  const std::uint32_t face = mesh.face_of_source(source);
  const Triangle t = face == kNone ? mesh.dropped_face(source) : mesh.faces()[face];
  const auto positions = mesh.positions();
  return (1.0 / 3) * (positions[t[0]] + positions[t[1]] + positions[t[2]]);
}

// Keeps the faces of shapes, or takes them away.
class Marker {
 public:
  Marker(const Mesh& mesh, std::span<const PartFaces> parts, Faces& faces, Poll& poll)
      : mesh_(mesh), parts_(parts), faces_(faces), poll_(poll) {}

  // Gives `value` to the faces of all these.
  Result<void> mark(const std::vector<Shape>& region, std::uint8_t value) {
    value_ = value;
    for (const Shape& shape : region) {
      parameter_ = &shape.parameter;
      if (auto marked = std::visit(*this, shape.what); !marked) return marked;
    }
    return {};
  }

  Result<void> operator()(const std::vector<FaceRange>& ranges) {
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (ranges[i].last >= mesh_.source_face_count()) {
        return fail_limit(ErrorCode::index_out_of_range, "the mesh has no such face",
                          mesh_.source_face_count() - 1, ranges[i].last,
                          *parameter_ + ".faces[" + std::to_string(i) + "]");
      }
    }
    // Ranges that overlap are gone through once: however many there are, a face is.
    std::vector<FaceRange> sorted = ranges;
    std::sort(sorted.begin(), sorted.end(),
              [](const FaceRange& a, const FaceRange& b) { return a.first < b.first; });
    std::uint64_t next = 0;
    for (const FaceRange& range : sorted) {
      for (next = std::max(next, range.first); next <= range.last && !poll_.cancelled(); ++next) {
        faces_[next] = value_;
      }
      if (poll_.cancelled()) return fail_stopped(poll_);
    }
    return {};
  }

  Result<void> operator()(const PartShape& shape) {
    if (shape.part >= parts_.size()) {
      return fail_limit(ErrorCode::index_out_of_range,
                        parts_.empty() ? "the mesh lists no parts" : "the mesh lists no such part",
                        parts_.empty() ? 0 : parts_.size() - 1, shape.part, *parameter_ + ".part");
    }
    const auto [first, count] = parts_[shape.part];
    for (std::uint64_t f = first; f < faces_.size() && f - first < count; ++f) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      faces_[f] = value_;
    }
    return {};
  }

  Result<void> operator()(const SphereShape& shape) {
    return mark_if([&](Vec3 p) { return distance(p, shape.center) <= shape.radius; });
  }

  Result<void> operator()(const BoxShape& shape) {
    const auto& [min, max] = shape;
    return mark_if([&min = min, &max = max](Vec3 p) {
      return min.x <= p.x && p.x <= max.x && min.y <= p.y && p.y <= max.y && min.z <= p.z &&
             p.z <= max.z;
    });
  }

 private:
  template <class Inside>
  Result<void> mark_if(Inside&& is_inside) {
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      if (faces_[f] != value_ && is_inside(centroid_of(mesh_, f))) faces_[f] = value_;
    }
    return {};
  }

  const Mesh& mesh_;
  std::span<const PartFaces> parts_;
  Faces& faces_;
  Poll& poll_;
  std::uint8_t value_ = 0;
  const std::string* parameter_ = nullptr;
};

}  // namespace

Result<Mesh> cut_regions(const Mesh& whole, const Regions& regions,
                         std::span<const PartFaces> parts, const Cancel& cancel) {
  Poll poll(cancel);
  Faces left;
  polled_assign(left, whole.source_face_count(), std::uint8_t{regions.within.empty()}, poll);
  if (poll.stopped()) return fail_stopped(poll);
  Marker marker(whole, parts, left, poll);
  if (auto kept = marker.mark(regions.within, 1); !kept) return fail(std::move(kept.error()));
  if (auto taken = marker.mark(regions.forbid, 0); !taken) return fail(std::move(taken.error()));
  auto cut = cut_mesh(whole, left, cancel);
  if (cut || !(cut.error().code == ErrorCode::no_triangles)) return cut;
  return fail(ErrorCode::value_out_of_range, "no face of the mesh is left",
              regions.forbid.empty() ? "within" : "forbid");
}

}  // namespace geodesic::proto
