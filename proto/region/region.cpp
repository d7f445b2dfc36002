#include "proto/region/region.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

void append_numbers(std::string& out, std::string_view kind, std::initializer_list<double> all) {
  out += kind;
  for (const double number : all) {
    out += ',';
    append_number(out, number);
  }
}

void append_points(std::string& out, const std::vector<PointRequest>& points) {
  for (const PointRequest& point : points) {
    out += ';';
    if (const auto* vertex = std::get_if<VertexRequest>(&point.where)) {
      out += "v,";
      out += std::to_string(vertex->vertex);
    } else if (const auto* face = std::get_if<FaceRequest>(&point.where)) {
      out += "f,";
      out += std::to_string(face->face);
      append_numbers(out, "", {face->bary[0], face->bary[1], face->bary[2]});
    } else if (const auto* place = std::get_if<SpaceRequest>(&point.where)) {
      append_numbers(out, "p", {place->xyz.x, place->xyz.y, place->xyz.z});
      if (place->max_snap) append_numbers(out, ",snap", {*place->max_snap});
    } else {
      const auto& [from, ahead] = std::get<RayRequest>(point.where);
      append_numbers(out, "ray", {from.x, from.y, from.z, ahead.x, ahead.y, ahead.z});
    }
  }
}

// Whatever a name has in it, what follows cannot be taken for a part of it.
void append_name(std::string& out, const std::string& name) {
  out += std::to_string(name.size());
  out += ':';
  out += name;
}

struct ShapeText {
  std::string& out;

  void operator()(const std::vector<FaceRange>& ranges) const {
    out += "faces";
    for (const FaceRange& range : ranges) {
      out += ',';
      out += std::to_string(range.first);
      out += '-';
      out += std::to_string(range.last);
    }
  }
  void operator()(const PartShape& shape) const {
    out += "part,";
    append_place_or_name(shape.part);
  }
  void operator()(const MaterialShape& shape) const {
    out += "material,";
    append_place_or_name(shape.material);
  }
  void operator()(const LabelShape& shape) const {
    out += "label,";
    append_name(out, shape.attribute);
    append_numbers(out, "", {shape.value});
  }
  void operator()(const SphereShape& shape) const {
    append_numbers(out, "sphere", {shape.center.x, shape.center.y, shape.center.z, shape.radius});
  }
  void operator()(const BoxShape& shape) const {
    append_numbers(out, "box",
                   {shape.min.x, shape.min.y, shape.min.z, shape.max.x, shape.max.y, shape.max.z});
  }
  void operator()(const InsideShape& shape) const {
    out += "inside";
    append_points(out, shape.points);
  }

 private:
  template <class PlaceOrName>
  void append_place_or_name(const PlaceOrName& value) const {
    if (const auto* place = std::get_if<std::uint64_t>(&value)) {
      out += std::to_string(*place);
    } else if (const auto* name = std::get_if<std::string>(&value)) {
      append_name(out, *name);
    } else {
      out += "none";
    }
  }
};

void append_region(std::string& out, std::string_view name, const std::vector<Shape>& region) {
  out += name;
  for (const Shape& shape : region) {
    out += ' ';
    std::visit(ShapeText{out}, shape.what);
  }
}

bool is_inside_of_line(const Shape& shape) {
  return std::holds_alternative<InsideShape>(shape.what);
}

}  // namespace

bool LabelShape::is_compared_exactly(double value) {
  return std::abs(value) <= 0x1p53 && std::trunc(value) == value;
}

bool LabelShape::is_of(double label) const {
  if (is_compared_exactly(value)) return label == value;
  return static_cast<float>(label) == static_cast<float>(value);
}

void NamedOfFile::add(const Shape& shape) {
  parts = parts || std::holds_alternative<PartShape>(shape.what);
  materials = materials || std::holds_alternative<MaterialShape>(shape.what);
  if (const auto* label = std::get_if<LabelShape>(&shape.what)) {
    labels.emplace(label->attribute, shape.parameter + ".label");
  }
}

NamedOfFile Regions::named_of_file() const {
  NamedOfFile named;
  for (const Shape& shape : within) named.add(shape);
  for (const Shape& shape : forbid) named.add(shape);
  return named;
}

bool Regions::has_lines() const {
  return !walls.empty() || std::any_of(within.begin(), within.end(), is_inside_of_line) ||
         std::any_of(forbid.begin(), forbid.end(), is_inside_of_line);
}

std::string canonical_text(const Regions& regions) {
  std::string text;
  append_region(text, "within", regions.within);
  append_region(text, " forbid", regions.forbid);
  if (!regions.walls.empty()) text += " walls";
  for (const Wall& wall : regions.walls) {
    text += ' ';
    append_points(text, wall.points);
  }
  return text;
}

}  // namespace geodesic::proto
