// Source faces of a mesh told apart by the shapes of regions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "proto/region/cut_regions.h"
#include "proto/region/region.h"

namespace geodesic::proto {

// The mean of a face's corners; the source face may have been dropped.
inline Vec3 centroid_of(const Mesh& mesh, std::uint32_t source) {
  const std::uint32_t face = mesh.face_of_source(source);
  const Triangle t = face == kNone ? mesh.dropped_face(source) : mesh.faces()[face];
  const auto positions = mesh.positions();
  return (1.0 / 3) * (positions[t[0]] + positions[t[1]] + positions[t[2]]);
}

// Gives values to the faces of shapes: `faces` has one for each source face.
template <class Value>
class FaceMarker {
 public:
  FaceMarker(const Mesh& mesh, const FileFaces& file, std::vector<Value>& faces, Poll& poll)
      : mesh_(mesh), file_(file), faces_(faces), poll_(poll) {}

  // Gives `value` to the faces of a shape. Errors: index_out_of_range, value_out_of_range (an
  // inside), those of parts_meant, materials_meant and no_such_label, cancelled.
  Result<void> mark(const Shape& shape, Value value) {
    value_ = value;
    parameter_ = &shape.parameter;
    return std::visit(*this, shape.what);
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
    const auto parts = parts_meant(file_, shape, *parameter_ + ".part");
    if (!parts) return fail(parts.error());
    for (const std::size_t place : *parts) {
      const ToldPart& part = file_.parts.parts[place];
      for (std::uint64_t f = part.first_face;
           f < faces_.size() && f - part.first_face < part.face_count; ++f) {
        if (poll_.cancelled()) return fail_stopped(poll_);
        faces_[f] = value_;
      }
    }
    return {};
  }

  Result<void> operator()(const MaterialShape& shape) {
    const auto meant = materials_meant(file_, shape, *parameter_ + ".material");
    if (!meant) return fail(meant.error());
    std::uint64_t next = 0;
    const auto mark_until = [&](std::uint64_t end, std::uint32_t material) {
      const bool is_meant = meant->has(material);
      for (end = std::min<std::uint64_t>(end, faces_.size()); next < end; ++next) {
        if (poll_.cancelled()) return;
        if (is_meant) faces_[next] = value_;
      }
    };
    if (file_.materials != nullptr) {
      for (const MaterialRun& run : file_.materials->runs) mark_until(run.end, run.material);
    }
    mark_until(faces_.size(), kNoMaterial);
    if (poll_.stopped()) return fail_stopped(poll_);
    return {};
  }

  Result<void> operator()(const LabelShape& shape) {
    const auto labels = file_.labels.find(shape.attribute);
    const std::vector<double>& by_face = labels->second->by_face;
    bool is_there = false;
    for (std::size_t f = 0; f < faces_.size() && f < by_face.size(); ++f) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      if (!shape.is_of(by_face[f])) continue;
      faces_[f] = value_;
      is_there = true;
    }
    if (is_there) return {};
    return no_such_label(by_face, shape, *parameter_ + ".label", poll_);
  }

  Result<void> operator()(const InsideShape&) {
    return fail(ErrorCode::value_out_of_range,
                "the inside of a line is for within and forbid alone: it is no set of whole faces",
                *parameter_);
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
      // What other regions have cut away already is not there to look at.
      if (mesh_.face_of_source(f) == kNone && !mesh_.is_dropped(f)) continue;
      if (faces_[f] != value_ && is_inside(centroid_of(mesh_, f))) faces_[f] = value_;
    }
    return {};
  }

  const Mesh& mesh_;
  const FileFaces& file_;
  std::vector<Value>& faces_;
  Poll& poll_;
  Value value_ = 0;
  const std::string* parameter_ = nullptr;
};

}  // namespace geodesic::proto
