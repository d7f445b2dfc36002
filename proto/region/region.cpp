#include "proto/region/region.h"

#include <algorithm>
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
    out += std::to_string(shape.part);
  }
  void operator()(const SphereShape& shape) const {
    append_numbers(out, "sphere", {shape.center.x, shape.center.y, shape.center.z, shape.radius});
  }
  void operator()(const BoxShape& shape) const {
    append_numbers(out, "box",
                   {shape.min.x, shape.min.y, shape.min.z, shape.max.x, shape.max.y, shape.max.z});
  }
};

void append_region(std::string& out, std::string_view name, const std::vector<Shape>& region) {
  out += name;
  for (const Shape& shape : region) {
    out += ' ';
    std::visit(ShapeText{out}, shape.what);
  }
}

bool is_part(const Shape& shape) { return std::holds_alternative<PartShape>(shape.what); }

}  // namespace

bool Regions::names_parts() const {
  return std::any_of(within.begin(), within.end(), is_part) ||
         std::any_of(forbid.begin(), forbid.end(), is_part);
}

std::string canonical_text(const Regions& regions) {
  std::string text;
  append_region(text, "within", regions.within);
  append_region(text, " forbid", regions.forbid);
  return text;
}

}  // namespace geodesic::proto
