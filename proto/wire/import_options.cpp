#include "proto/wire/import_options.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/wire/cut_to.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

constexpr double kLeastScale = 1e-30;
constexpr double kMostScale = 1e30;

tl::unexpected<Error> wrong(const char* parameter, const char* detail,
                            ErrorCode code = InputCode::bad_syntax) {
  return fail(code, detail, parameter);
}

Result<std::optional<std::string>> index_or_name(Parameters& parameters, const char* name) {
  auto text = parameters.text(name);
  if (text && *text &&
      ((*text)->empty() || (*text)->size() > kMostChosenNameBytes || !is_utf8(**text))) {
    return wrong(name, "an index, or a name of at most 512 bytes of UTF-8, is wanted");
  }
  // 007 and 7 are the same index and must have the same id.
  if (text && *text) {
    if (const auto index = parse_whole(**text)) return std::to_string(*index);
  }
  return text;
}

Result<void> read_weld(Parameters& parameters, ImportOptions& options) {
  const auto text = parameters.text("weld");
  if (!text) return fail(text.error());
  if (!*text) return {};
  if (**text == "off") {
    options.weld = Weld::off;
    return {};
  }
  const auto tolerance = parse_finite(**text);
  if (!tolerance) return wrong("weld", "a length in mesh units, or `off`, is wanted");
  if (*tolerance != 0 &&
      !(*tolerance >= Mesh::kMinCoordinate && *tolerance <= Mesh::kMaxCoordinate)) {
    return wrong("weld", "a length of 1e-60 to 1e60, 0 or `off` is wanted",
                 ErrorCode::value_out_of_range);
  }
  options.weld_tolerance = *tolerance + 0.0;  // -0 is 0
  return {};
}

}  // namespace

Result<ImportOptions> read_import_options(Parameters& parameters) {
  ImportOptions options;
  auto scene = index_or_name(parameters, "scene");
  if (!scene) return fail(std::move(scene.error()));
  options.scene = std::move(*scene);
  auto node = index_or_name(parameters, "node");
  if (!node) return fail(std::move(node.error()));
  options.node = std::move(*node);
  if (auto weld = read_weld(parameters, options); !weld) return fail(std::move(weld.error()));
  const auto up = parameters.text("up");
  if (!up) return fail(up.error());
  if (*up) {
    if (**up == "x") {
      options.up = UpAxis::x;
    } else if (**up == "z") {
      options.up = UpAxis::z;
    } else if (**up != "y") {
      return wrong("up", "the axis x, y or z is wanted", ErrorCode::value_out_of_range);
    }
  }
  const auto scale = parameters.number("scale");
  if (!scale) return fail(scale.error());
  if (*scale) {
    if (!(**scale >= kLeastScale && **scale <= kMostScale)) {
      return wrong("scale", "a positive factor from 1e-30 to 1e30 is wanted",
                   ErrorCode::value_out_of_range);
    }
    options.scale = **scale;
  }
  return options;
}

std::string canonical_text(const ImportOptions& options) {
  const auto number = [](double value) {
    std::string text;
    append_number(text, value);
    return text;
  };
  const auto quoted = [](const std::string& text) { return nlohmann::json(text).dump(); };
  std::string text;
  const auto add = [&](const char* name, const std::string& value) {
    text += text.empty() ? "{\"" : ",\"";
    text += name;
    text += "\":" + value;
  };
  if (options.node) add("node", quoted(*options.node));
  if (options.scale != 1) add("scale", number(options.scale));
  if (options.scene) add("scene", quoted(*options.scene));
  if (options.up != UpAxis::y) add("up", options.up == UpAxis::x ? "\"x\"" : "\"z\"");
  if (options.weld == Weld::off) {
    add("weld", "\"off\"");
  } else if (options.weld_tolerance != 0) {
    add("weld", quoted(number(options.weld_tolerance)));
  }
  return text.empty() ? text : text + "}";
}

void place(TriangleSoup& soup, const ImportOptions& options) {
  if (options.up == UpAxis::y && options.scale == 1) return;
  for (Vec3& p : soup.positions) {
    if (options.up == UpAxis::z) p = {p.x, p.z, -p.y};
    if (options.up == UpAxis::x) p = {-p.y, p.x, p.z};
    p = options.scale * p;
  }
}

}  // namespace geodesic::proto
