// A region of a mesh's surface as a client names it, before it is held against a mesh. One grammar
// everywhere (docs: "Regions" in openapi.yaml):
//   in a URL                 in JSON
//   faces:7,10-99            {"faces":[7,[10,99]]}                         source faces
//   part:2                   {"part":2}                                    a part of the file
//   part:roof                {"part":"roof"}                               all parts of that name
//   material:3               {"material":3}                                faces of a material
//   material:glass           {"material":"glass"}                          of all of that name
//   material:none            {"material":null}                             faces without one
//   label:_SEG=3             {"label":{"attribute":"_SEG","value":3}}      faces with that label
//   sphere:X,Y,Z,R           {"sphere":{"center":[X,Y,Z],"radius":R}}      a ball in space
//   box:X,Y,Z,X,Y,Z          {"box":{"min":[X,Y,Z],"max":[X,Y,Z]}}         a box in space
//   inside:POINT;POINT;POINT {"inside":[POINT,POINT,POINT]}                what a line goes round
// and a wall, which is a line that nothing crosses, POINT;POINT or {"points":[POINT,POINT]}; closed
// if it ends with the point that it begins with.
// JSON accepts the URL's text as well. There, a name goes on to the end of the text. What is
// written in digits is a number, and none is no material, unless it stands in double quotes:
// material:"3" is what {"material":"3"} is. These are taken away from any name that begins and ends
// with them, and all between them is the name as it is. A label is a number that all three corners
// of a face have in an attribute of the file's vertices. Of a ball or a box, with its border, the
// region has the faces whose centroids (the means of their corners) lie in it. Several shapes are
// their union. Lines go from point to point straight in a face that has both, or by the shortest
// path. A line that goes round leads back from its last point to the first; the largest of the
// parts into which it divides the surface is outside, the others are inside, cut out of faces where
// it crosses them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "core/base/vec3.h"
#include "proto/wire/point_request.h"

namespace geodesic::proto {

// Source faces, both ends among them.
struct FaceRange {
  std::uint64_t first;
  std::uint64_t last;
};

// By its place in the metadata's `parts`, or all that have a name there.
struct PartShape {
  std::variant<std::uint64_t, std::string> part;
};

struct NoMaterial {};

// By its place in the metadata's `materials`, or all that have a name there.
struct MaterialShape {
  std::variant<std::uint64_t, std::string, NoMaterial> material;
};

struct LabelShape {
  std::string attribute;
  double value;  // within a float's range

  // Whether a label is the value. Whole numbers are compared as they are, others as floats, for
  // such a number is nearly always a float's digits.
  [[nodiscard]] bool is_of(double label) const;
  // Whole numbers, as far as doubles have all of them.
  [[nodiscard]] static bool is_compared_exactly(double value);
};

struct SphereShape {
  Vec3 center;
  double radius;  // mesh units, not negative
};

struct BoxShape {
  Vec3 min;
  Vec3 max;  // not less than `min`
};

struct InsideShape {
  std::vector<PointRequest> points;  // three or more
};

struct Shape {
  std::variant<std::vector<FaceRange>, PartShape, MaterialShape, LabelShape, SphereShape, BoxShape,
               InsideShape>
      what;
  std::string parameter;  // where the client wrote it, such as "forbid[2]", for errors
};

// What shapes name that only the file tells.
struct NamedOfFile {
  bool parts = false;
  bool materials = false;
  std::map<std::string, std::string> labels;  // attributes, and where each was written first

  void add(const Shape& shape);
};

struct Wall {
  std::vector<PointRequest> points;  // two or more
  std::string parameter;             // as a shape's
};

// The part of a surface that a query is about: of what is in `within`, or of all if that is empty,
// what is not in `forbid`; cut along the walls.
struct Regions {
  std::vector<Shape> within;
  std::vector<Shape> forbid;
  std::vector<Wall> walls;

  [[nodiscard]] bool is_everything() const {
    return within.empty() && forbid.empty() && walls.empty();
  }
  [[nodiscard]] NamedOfFile named_of_file() const;
  // Whether faces have to be split: there are walls or insides.
  [[nodiscard]] bool has_lines() const;
};

// The same for two spellings of the same shapes in the same order, and for nothing else.
[[nodiscard]] std::string canonical_text(const Regions& regions);

}  // namespace geodesic::proto
