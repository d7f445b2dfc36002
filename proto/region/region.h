// A region of a mesh's surface as a client names it, before it is held against a mesh. One grammar
// everywhere (docs: "Regions" in openapi.yaml):
//   in a URL                 in JSON
//   faces:7,10-99            {"faces":[7,[10,99]]}                         source faces
//   part:2                   {"part":2}                                    a part of the file
//   sphere:X,Y,Z,R           {"sphere":{"center":[X,Y,Z],"radius":R}}      a ball in space
//   box:X,Y,Z,X,Y,Z          {"box":{"min":[X,Y,Z],"max":[X,Y,Z]}}         a box in space
// JSON accepts the URL's text as well. Of a ball or a box, with its border, the region has the
// faces whose centroids (the means of their corners) lie in it. Several shapes are their union.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/base/vec3.h"

namespace geodesic::proto {

// Source faces, both ends among them.
struct FaceRange {
  std::uint64_t first;
  std::uint64_t last;
};

// By its place in the metadata's `parts`.
struct PartShape {
  std::uint64_t part;
};

struct SphereShape {
  Vec3 center;
  double radius;  // mesh units, not negative
};

struct BoxShape {
  Vec3 min;
  Vec3 max;  // not less than `min`
};

struct Shape {
  std::variant<std::vector<FaceRange>, PartShape, SphereShape, BoxShape> what;
  std::string parameter;  // where the client wrote it, such as "forbid[2]", for errors
};

// The part of a surface that a query is about: of what is in `within`, or of all if that is empty,
// what is not in `forbid`.
struct Regions {
  std::vector<Shape> within;
  std::vector<Shape> forbid;

  [[nodiscard]] bool is_everything() const { return within.empty() && forbid.empty(); }
  [[nodiscard]] bool names_parts() const;
};

// The same for two spellings of the same shapes in the same order, and for nothing else.
[[nodiscard]] std::string canonical_text(const Regions& regions);

}  // namespace geodesic::proto
