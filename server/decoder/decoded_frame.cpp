#include "server/decoder/decoded_frame.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/polled_fill.h"
#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"

namespace geodesic::server {
namespace {

// One description of what is in a frame serves all three: measuring, writing, reading.
class Measure {
 public:
  void bytes(const void* /*data*/, std::size_t count) { size_ += count; }
  void resize(const auto& /*values*/, std::uint64_t /*count*/, std::size_t /*each*/) {}
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

class Write {
 public:
  explicit Write(std::byte* to) : to_(to) {}
  void bytes(const void* data, std::size_t count) {
    if (count != 0) std::memcpy(to_, data, count);
    to_ += count;
  }
  void resize(const auto& /*values*/, std::uint64_t /*count*/, std::size_t /*each*/) {}

 private:
  std::byte* to_;
};

// Who has read past the end, or is to stop, reads zeros from then on.
class Read {
 public:
  Read(std::span<const std::byte> from, const Cancel& cancel) : from_(from), poll_(cancel) {}
  void bytes(void* data, std::size_t count) {
    failed_ = failed_ || count > from_.size();
    if (count == 0) return;
    if (failed_) {
      std::memset(data, 0, count);
      return;
    }
    std::memcpy(data, from_.data(), count);
    from_ = from_.subspan(count);
  }
  // Takes memory for no more than there can be.
  template <class Values>
  void resize(Values& values, std::uint64_t count, std::size_t each) {
    failed_ = failed_ || count > from_.size() / each;
    values.resize(failed_ ? 0 : count);
  }
  // So many elements, no more than there can be, each written once.
  template <class Values>
  void assign(Values& values, std::uint64_t count) {
    using Element = typename Values::value_type;
    failed_ = failed_ || count > from_.size() / sizeof(Element);
    values.clear();
    if (failed_) return;
    const auto* first = reinterpret_cast<const Element*>(from_.data());
    if (reinterpret_cast<std::uintptr_t>(first) % alignof(Element) == 0) {
      polled_copy(values, std::span(first, count), poll_);
      failed_ = poll_.stopped();
      from_ = from_.subspan(count * sizeof(Element));
    } else {
      values.resize(count);
      bytes(values.data(), count * sizeof(Element));
    }
  }
  void fail() { failed_ = true; }
  [[nodiscard]] bool is_complete() const { return !failed_ && from_.empty(); }

 private:
  std::span<const std::byte> from_;
  Poll poll_;
  bool failed_ = false;
};

template <class Archive, class Value>
void field(Archive& archive,
           Value& value) requires std::is_arithmetic_v<std::remove_const_t<Value>> {
  archive.bytes(&value, sizeof(value));
}

template <class Archive, class Value>
void field(Archive& archive, Value& value) requires std::is_enum_v<std::remove_const_t<Value>> {
  // As wide as a number, so that arrays that follow lie where they can be read at once.
  auto number = static_cast<std::uint64_t>(value);
  field(archive, number);
  if constexpr (std::is_same_v<Archive, Read>) {
    using Enum = std::remove_const_t<Value>;
    if (number > std::numeric_limits<std::underlying_type_t<Enum>>::max()) archive.fail();
    value = static_cast<Enum>(number);
  }
}

// Text, and arrays of numbers or of structures of numbers without gaps.
template <class Archive, class Values>
void array(Archive& archive, Values& values) {
  using Element = typename std::remove_const_t<Values>::value_type;
  static_assert(std::is_trivially_copyable_v<Element>);
  std::uint64_t count = values.size();
  field(archive, count);
  if constexpr (std::is_same_v<Archive, Read>) {
    archive.assign(values, count);
  } else {
    archive.bytes(values.data(), values.size() * sizeof(Element));
  }
}

template <class Archive, class Value>
void optional(Archive& archive, Value& value) {
  std::uint8_t has = value.has_value() ? 1 : 0;
  auto inner = value.value_or(0);
  field(archive, has);
  field(archive, inner);
  if constexpr (std::is_same_v<Archive, Read>) {
    if (has == 1) value = inner;
  }
}

// A part, a finding, a text and an attribute take no less than their counts and numbers do.
constexpr std::size_t kLeastOfPart = 9 * sizeof(std::uint64_t);
constexpr std::size_t kLeastOfFinding = 4 * sizeof(std::uint64_t);
constexpr std::size_t kLeastOfText = sizeof(std::uint64_t);
constexpr std::size_t kLeastOfAttribute = 2 * sizeof(std::uint64_t);

template <class Archive, class Part>
void part_fields(Archive& archive, Part& part) {
  field(archive, part.node);
  field(archive, part.mesh);
  field(archive, part.primitive);
  array(archive, part.name);
  field(archive, part.first_vertex);
  field(archive, part.vertex_count);
  field(archive, part.first_face);
  field(archive, part.face_count);
  field(archive, part.material);
}

template <class Archive, class Materials>
void material_fields(Archive& archive, Materials& materials) {
  std::uint64_t names = materials.names.size();
  field(archive, names);
  archive.resize(materials.names, names, kLeastOfText);
  for (auto& name : materials.names) array(archive, name);
  array(archive, materials.runs);
}

template <class Archive, class Finding>
void finding_fields(Archive& archive, Finding& finding) {
  array(archive, finding.code);
  field(archive, finding.count);
  std::uint64_t examples = finding.examples.size();
  field(archive, examples);
  archive.resize(finding.examples, examples, kLeastOfText);
  for (auto& example : finding.examples) array(archive, example);
  array(archive, finding.text);
}

template <class Archive, class Mesh>
void mesh_fields(Archive& archive, Mesh& mesh) {
  field(archive, mesh.format);
  array(archive, mesh.soup.positions);
  array(archive, mesh.soup.faces);
  std::uint64_t parts = mesh.parts.size();
  field(archive, parts);
  archive.resize(mesh.parts, parts, kLeastOfPart);
  for (auto& part : mesh.parts) part_fields(archive, part);
  field(archive, mesh.part_count);
  material_fields(archive, mesh.materials);
  std::uint64_t findings = mesh.findings.size();
  field(archive, findings);
  archive.resize(mesh.findings, findings, kLeastOfFinding);
  for (auto& finding : mesh.findings) finding_fields(archive, finding);
}

// What a decoder may say of a file. A frame that names another code is damaged.
constexpr std::array kCodes{
    ErrorCode::too_large,          ErrorCode::mesh_invalid,       ErrorCode::no_triangles,
    ErrorCode::too_many_vertices,  ErrorCode::too_many_faces,     ErrorCode::index_out_of_range,
    ErrorCode::value_out_of_range, ErrorCode::unsupported,        ErrorCode::cancelled,
    ErrorCode::internal,           InputCode::bad_syntax,         InputCode::unknown_parameter,
    InputCode::format_unknown,     InputCode::extension_required, InputCode::external_uri,
    InputCode::not_acceptable,     ServiceCode::overloaded,
};

template <class Archive, class Code>
void code_field(Archive& archive, Code& code) {
  std::string name(code.name());
  array(archive, name);
  if constexpr (std::is_same_v<Archive, Read>) {
    const auto* const known = std::find_if(kCodes.begin(), kCodes.end(),
                                           [&](ErrorCode one) { return one.name() == name; });
    if (known == kCodes.end()) return archive.fail();
    code = *known;
  }
}

template <class Archive, class Problem>
void error_fields(Archive& archive, Problem& error) {
  code_field(archive, error.code);
  array(archive, error.detail);
  array(archive, error.parameter);
  optional(archive, error.limit);
  optional(archive, error.actual);
}

template <class Archive, class Text>
void optional_text(Archive& archive, Text& text) {
  std::uint64_t has = text.has_value() ? 1 : 0;
  auto inner = text.value_or(std::string());
  field(archive, has);
  array(archive, inner);
  if constexpr (std::is_same_v<Archive, Read>) {
    if (has == 1) text = std::move(inner);
  }
}

template <class Archive, class Options>
void option_fields(Archive& archive, Options& options) {
  optional_text(archive, options.scene);
  optional_text(archive, options.node);
  field(archive, options.weld_tolerance);
  field(archive, options.weld);
  field(archive, options.up);
  field(archive, options.scale);
}

template <class Archive, class Order>
void order_fields(Archive& archive, Order& order) {
  array(archive, order.boundary);
  std::uint64_t attributes = order.attributes.size();
  field(archive, attributes);
  archive.resize(order.attributes, attributes, kLeastOfAttribute);
  for (auto& attribute : order.attributes) {
    array(archive, attribute.name);
    field(archive, attribute.components);
  }
  array(archive, order.numbers);
  field(archive, order.which);
  field(archive, order.limits.max_vertices);
  field(archive, order.limits.max_faces);
  field(archive, order.limits.max_nodes);
  field(archive, order.limits.max_gltf_objects);
  field(archive, order.limits.max_json_depth);
  field(archive, order.limits.max_json_values);
  option_fields(archive, order.options);
  field(archive, order.file_bytes);
  field(archive, order.memory_bytes);
  field(archive, order.cpu_seconds);
}

// What a frame says first that it holds.
constexpr std::uint64_t kError = 0;
template <class Content>
constexpr std::uint64_t kKind = std::is_same_v<Content, proto::DecodedMesh>      ? 1
                                : std::is_same_v<Content, FormFile>              ? 2
                                : std::is_same_v<Content, proto::GltfAnnotation> ? 3
                                                                                 : 4;

template <class Archive, class Mesh>
requires std::is_same_v<std::remove_const_t<Mesh>, proto::DecodedMesh>
void content_fields(Archive& archive, Mesh& mesh) { mesh_fields(archive, mesh); }

template <class Archive, class File>
requires std::is_same_v<std::remove_const_t<File>, FormFile>
void content_fields(Archive& archive, File& file) {
  array(archive, file.name);
  array(archive, file.bytes);
}

template <class Archive, class Annotation>
requires std::is_same_v<std::remove_const_t<Annotation>, proto::GltfAnnotation>
void content_fields(Archive& archive, Annotation& annotation) {
  array(archive, annotation.json);
  field(archive, annotation.values_at);
  array(archive, annotation.runs);
}

template <class Archive, class Numbers>
requires std::is_same_v<std::remove_const_t<Numbers>, proto::FaceNumbers>
void content_fields(Archive& archive, Numbers& numbers) { array(archive, numbers.by_face); }

template <class Archive, class Content>
void frame_fields(Archive& archive, const Result<Content>& answer) {
  const std::uint64_t kind = answer ? kKind<Content> : kError;
  field(archive, kind);
  if (answer) {
    content_fields(archive, *answer);
  } else {
    error_fields(archive, answer.error());
  }
}

// A format without a name is a number that no decoder of ours writes.
bool is_known(const proto::DecodedMesh& mesh) { return !proto::name_of(mesh.format).empty(); }
bool is_known(const FormFile& /*file*/) { return true; }
bool is_known(const proto::GltfAnnotation& /*annotation*/) { return true; }
bool is_known(const proto::FaceNumbers& /*numbers*/) { return true; }

}  // namespace

std::string write_order(const DecodeOrder& order) {
  Measure measure;
  order_fields(measure, order);
  std::string bytes(measure.size(), '\0');
  Write write(reinterpret_cast<std::byte*>(bytes.data()));
  order_fields(write, order);
  return bytes;
}

std::optional<DecodeOrder> read_order(std::string_view bytes) {
  const Cancel never;
  Read read({reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()}, never);
  DecodeOrder order;
  order_fields(read, order);
  if (!read.is_complete()) return std::nullopt;
  return order;
}

template <class Content>
std::size_t frame_size(const Result<Content>& answer) {
  Measure measure;
  frame_fields(measure, answer);
  return measure.size();
}

template <class Content>
void write_frame(const Result<Content>& answer, std::span<std::byte> frame) {
  Write write(frame.data());
  frame_fields(write, answer);
}

template <class Content>
std::optional<Result<Content>> read_frame(std::span<const std::byte> frame, const Cancel& cancel) {
  Read read(frame, cancel);
  std::uint64_t kind = kError;
  field(read, kind);
  if (kind == kKind<Content>) {
    Content content;
    content_fields(read, content);
    if (!read.is_complete() || !is_known(content)) return std::nullopt;
    return content;
  }
  Error error;
  error_fields(read, error);
  if (kind != kError || !read.is_complete()) return std::nullopt;
  return fail(std::move(error));
}

template std::size_t frame_size(const Decoded&);
template std::size_t frame_size(const Result<FormFile>&);
template std::size_t frame_size(const Result<proto::GltfAnnotation>&);
template std::size_t frame_size(const Result<proto::FaceNumbers>&);
template void write_frame(const Decoded&, std::span<std::byte>);
template void write_frame(const Result<FormFile>&, std::span<std::byte>);
template void write_frame(const Result<proto::GltfAnnotation>&, std::span<std::byte>);
template void write_frame(const Result<proto::FaceNumbers>&, std::span<std::byte>);
template std::optional<Decoded> read_frame(std::span<const std::byte>, const Cancel&);
template std::optional<Result<FormFile>> read_frame(std::span<const std::byte>, const Cancel&);
template std::optional<Result<proto::GltfAnnotation>> read_frame(std::span<const std::byte>,
                                                                 const Cancel&);
template std::optional<Result<proto::FaceNumbers>> read_frame(std::span<const std::byte>,
                                                              const Cancel&);

}  // namespace geodesic::server
