#include "proto/wire/reply_format.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

struct FormatName {
  Format format;
  std::string_view name;
  std::string_view media_type;
};

constexpr FormatName kNames[] = {{Format::json, "json", "application/json"},
                                 {Format::f32, "f32", "application/octet-stream"},
                                 {Format::f64, "f64", "application/octet-stream"},
                                 {Format::u16, "u16", "application/octet-stream"},
                                 {Format::npy, "npy", "application/x-npy"},
                                 {Format::frame, "frame", "application/vnd.geodesic.frame"},
                                 {Format::glb, "glb", "model/gltf-binary"},
                                 {Format::png, "png", "image/png"},
                                 // Its reply has the type of the file that was uploaded.
                                 {Format::annotated, "annotated", "model/gltf-binary"},
                                 {Format::lines, "ndjson", "application/x-ndjson"},
                                 {Format::npz, "npz", "application/x-npz"}};

const FormatName& row_of(Format format) { return kNames[static_cast<std::size_t>(format)]; }

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Cuts the next element off a list.
std::string_view next_of(std::string_view& list, char separator) {
  const std::size_t end = list.find(separator);
  const std::string_view element = list.substr(0, end);
  list = end == list.npos ? std::string_view() : list.substr(end + 1);
  return trimmed(element);
}

// The quality that a range's parameters give it; what is no number counts as 0.
double quality_of(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string_view parameter = next_of(parameters, ';');
    if (!parameter.starts_with("q=") && !parameter.starts_with("Q=")) continue;
    double quality = 0;
    std::from_chars(parameter.data() + 2, parameter.data() + parameter.size(), quality);
    return quality >= 0 && quality <= 1 ? quality : 0;
  }
  return 1;
}

// How welcome a media type is: the quality of the most specific range that it is in.
double quality_of(std::string_view accept, std::string_view type) {
  const std::string_view family = type.substr(0, type.find('/') + 1);
  int best = 0;
  double quality = 0;
  while (!accept.empty()) {
    std::string_view entry = next_of(accept, ',');
    std::string range(next_of(entry, ';'));
    std::transform(range.begin(), range.end(), range.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    const int specific = range == type                        ? 3
                         : range == std::string(family) + "*" ? 2
                         : range == "*/*"                     ? 1
                                                              : 0;
    if (specific <= best) continue;
    best = specific;
    quality = quality_of(entry);
  }
  return quality;
}

// The names, or the media types, of what is offered.
std::string list_of(std::span<const Format> offered, std::string_view FormatName::*column) {
  std::string list;
  for (const Format format : offered) {
    const std::string_view text = row_of(format).*column;
    if (list.find(text) != list.npos) continue;
    list += list.empty() ? "" : ", ";
    list += text;
  }
  return list;
}

Result<Format> choose(Parameters& parameters, const std::string* accept,
                      std::span<const Format> offered) {
  const auto name = parameters.text("format");
  if (!name) return fail(name.error());
  if (*name) {
    for (const Format format : offered) {
      if (**name == row_of(format).name) return format;
    }
    return fail(InputCode::not_acceptable,
                "this call has no such format; there are: " + list_of(offered, &FormatName::name),
                "format");
  }
  if (accept == nullptr || trimmed(*accept).empty()) return offered.front();
  std::optional<Format> best;
  double best_quality = 0;
  for (const Format format : offered) {
    const double quality = quality_of(*accept, row_of(format).media_type);
    if (quality <= best_quality) continue;
    best_quality = quality;
    best = format;
  }
  if (best) return *best;
  return fail(InputCode::not_acceptable,
              "offered are: " + list_of(offered, &FormatName::media_type), "Accept");
}

// A whole number within bounds, if there is one.
template <class Number>
Result<void> read_whole(Parameters& parameters, std::string_view name, std::uint64_t least,
                        std::uint64_t most, Number& number) {
  const auto value = parameters.whole(name);
  if (!value) return fail(value.error());
  if (!*value) return {};
  if (**value < least || **value > most) {
    return fail_limit(ErrorCode::value_out_of_range,
                      std::string(name) + " is a whole number from " + std::to_string(least) +
                          " to " + std::to_string(most),
                      most, **value, std::string(name));
  }
  number = static_cast<Number>(**value);
  return {};
}

Result<void> read_picture(Parameters& parameters, PictureOptions& picture) {
  constexpr std::uint64_t kLeast = PictureOptions::kMinSide;
  constexpr std::uint64_t kMost = PictureOptions::kMaxSide;
  if (auto read = read_whole(parameters, "width", kLeast, kMost, picture.width); !read) return read;
  if (auto read = read_whole(parameters, "height", kLeast, kMost, picture.height); !read)
    return read;
  if (auto read =
          read_whole(parameters, "stripes", 0, PictureOptions::kMaxStripes, picture.stripes);
      !read) {
    return read;
  }
  const auto view = parameters.text("view");
  if (!view) return fail(view.error());
  if (*view) {
    const auto parsed = parse_view(**view);
    if (!parsed) return fail(parsed.error());
    picture.view = *parsed;
  }
  return {};
}

Result<void> read_colours(Parameters& parameters, PictureOptions& picture) {
  const auto name = parameters.text("colormap");
  if (!name) return fail(name.error());
  if (!*name) return {};
  const auto map = find_colour_map(**name);
  if (!map) return fail(map.error());
  picture.colour_map = *map;
  return {};
}

// A name of one's own begins with an underscore, says glTF 2.0, section 3.7.2.1; that it is of
// these characters lets every reader take it for a name of its own language.
bool is_attribute_name(std::string_view name) {
  constexpr std::size_t kLongest = 64;
  return name.size() >= 2 && name.size() <= kLongest && name.front() == '_' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                  c == '_';
         });
}

Result<void> read_attributes(Parameters& parameters, ReplyFormat& reply) {
  if (auto read = read_attribute(parameters, "attribute", reply.attribute); !read) return read;
  const auto labels = parameters.flag("labels");
  if (!labels) return fail(labels.error());
  if (!labels->value_or(false)) return {};
  return read_attribute(parameters, "label_attribute", reply.label_attribute);
}

}  // namespace

Result<void> read_attribute(Parameters& parameters, const char* parameter, std::string& name) {
  auto given = parameters.text(parameter);
  if (!given) return fail(given.error());
  if (!*given) return {};
  if (!is_attribute_name(**given)) {
    return fail(ErrorCode::value_out_of_range,
                "an attribute of one's own is called by an underscore and 1 to 63 letters, digits "
                "and underscores, such as _HEAT",
                parameter);
  }
  name = std::move(**given);
  return {};
}

std::string_view name_of(Format format) { return row_of(format).name; }
std::string_view media_type_of(Format format) { return row_of(format).media_type; }

Result<ReplyFormat> parse_format(Parameters& parameters, const std::string* accept,
                                 std::span<const Format> offered) {
  const auto format = choose(parameters, accept, offered);
  if (!format) return fail(format.error());
  ReplyFormat reply;
  reply.format = *format;
  // Scripts may pass a precision whatever the format.
  if (auto read = read_whole(parameters, "precision", 1, 17, reply.precision); !read) {
    return fail(read.error());
  }
  if (*format == Format::png) {
    if (auto read = read_picture(parameters, reply.picture); !read) return fail(read.error());
  }
  if (*format == Format::png || *format == Format::glb) {
    if (auto read = read_colours(parameters, reply.picture); !read) return fail(read.error());
  }
  if (*format == Format::annotated) {
    if (auto read = read_attributes(parameters, reply); !read) return fail(read.error());
  }
  return reply;
}

}  // namespace geodesic::proto
