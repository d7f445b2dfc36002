// The format of a reply, by `format=` or by the Accept header.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "proto/picture/picture.h"
#include "proto/wire/parameters.h"

namespace geodesic::proto {

// `annotated`: the file that was uploaded, with the numbers as attributes of its vertices.
// `lines`: a line of JSON for each row of a table. `npz`: a sparse matrix as SciPy keeps it.
enum class Format : std::uint8_t {
  json,
  f32,
  f64,
  u16,
  npy,
  frame,
  glb,
  png,
  annotated,
  lines,
  npz
};

// What `format=` calls it, and its media type.
[[nodiscard]] std::string_view name_of(Format format);
[[nodiscard]] std::string_view media_type_of(Format format);

struct ReplyFormat {
  Format format = Format::json;
  int precision = 0;       // significant digits in JSON; 0: as many as the value has
  PictureOptions picture;  // of a PNG; of a GLB the colours
  // Of an annotated file: what its attributes are called; empty: by the query's own name.
  std::string attribute;
  std::string label_attribute;
};

// What the replies of a kind can be had as.
inline constexpr Format kJsonOnly[] = {Format::json};
inline constexpr Format kFieldFormats[] = {Format::json, Format::f32, Format::f64,
                                           Format::u16,  Format::npy, Format::frame,
                                           Format::glb,  Format::png, Format::annotated};
// Numbers that belong to no whole surface.
inline constexpr Format kArrayFormats[] = {Format::json, Format::f32, Format::f64,
                                           Format::u16,  Format::npy, Format::frame};
// Numbers below 0: none as parts of the greatest one.
inline constexpr Format kSignedFormats[] = {Format::json,     Format::f32,   Format::f64,
                                            Format::npy,      Format::frame, Format::glb,
                                            Format::annotated};
inline constexpr std::span<const Format> kSignedAtPoints(kSignedFormats, 5);
inline constexpr Format kPathFormats[] = {Format::json,  Format::f32, Format::f64, Format::npy,
                                          Format::frame, Format::glb, Format::png};
// Several arrays of several types.
inline constexpr Format kLabelsAtPoints[] = {Format::json, Format::frame};
inline constexpr Format kLabelFormats[] = {Format::json, Format::frame, Format::annotated};
inline constexpr Format kArraysOrSurface[] = {Format::json, Format::frame, Format::glb,
                                              Format::annotated};
inline constexpr Format kJsonOrSurface[] = {Format::json, Format::glb};
inline constexpr Format kJsonOrLines[] = {Format::json, Format::glb};
inline constexpr Format kSurfaceOnly[] = {Format::glb};
inline constexpr Format kJsonOrPictures[] = {Format::json, Format::glb, Format::png};
// What can be sent row after row.
inline constexpr Format kRowFormats[] = {Format::lines, Format::f32, Format::f64, Format::npy};
inline constexpr std::span<const Format> kLinesOnly(kRowFormats, 1);
inline constexpr Format kSparseFormats[] = {Format::json, Format::frame, Format::npz};
inline constexpr Format kGeometryFormats[] = {Format::glb, Format::frame};

// From `format=`, else from an Accept header (null: none), among what is offered, the
// first of which is the default. By RFC 9110, section 12.5.1: the highest quality
// wins, the most specific range decides, ties go to the one offered first. JSON reads
// `precision`, PNG `width`, `height`, `view`, `colormap` and `stripes`, GLB `colormap`,
// an annotated file `attribute` and, where labels are wanted, `label_attribute`.
// Errors: not_acceptable (naming what decided), bad_syntax, value_out_of_range.
[[nodiscard]] Result<ReplyFormat> parse_format(Parameters& parameters, const std::string* accept,
                                               std::span<const Format> offered);

// The name of an attribute of vertices in a glTF file, left as it is where there is no such
// parameter. Errors: bad_syntax, value_out_of_range.
[[nodiscard]] Result<void> read_attribute(Parameters& parameters, const char* parameter,
                                          std::string& name);

}  // namespace geodesic::proto
