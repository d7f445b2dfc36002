#include "proto/formats/decode_ply.h"

#include <rply.h>
#include <rplyfile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "proto/formats/ply_header.h"
#include "proto/mesh/one_part.h"
#include "proto/mesh/polygon_soup.h"
#include "proto/mesh/text_tokens.h"

namespace geodesic::proto {
namespace {

// What is left of the pieces that rply reads as one file.
using Pieces = std::array<std::string_view, 3>;

ssize_t read_pieces(void* cookie, char* buffer, std::size_t size) {
  std::size_t done = 0;
  for (std::string_view& piece : *static_cast<Pieces*>(cookie)) {
    const std::size_t taken = piece.copy(buffer + done, size - done);
    piece.remove_prefix(taken);
    done += taken;
  }
  return static_cast<ssize_t>(done);
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
struct ClosePly {
  void operator()(p_ply ply) const { ply_close(ply); }
};

// e_ply_type has each of eight types by two names, and then the list.
std::uint64_t size_of(e_ply_type type) {
  static constexpr std::array<std::uint64_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type) % kSizes.size()];
}
bool is_integer(e_ply_type type) { return type < PLY_LIST && type % 8 < PLY_FLOAT32; }

class PlyReader {
 public:
  PlyReader(const PlyHeader& header, const DecodeLimits& limits)
      // After a text, the end of a line: rply reads on past the last word without one.
      : pieces_{header.lines, header.data, header.is_text ? "\n" : ""},
        bytes_left_(header.data.size()),
        is_text_(header.is_text),
        soup_(limits) {}

  Result<TriangleSoup> run(Findings& findings) {
    const std::unique_ptr<std::FILE, CloseFile> file(
        fopencookie(&pieces_, "rb", {read_pieces, nullptr, nullptr, nullptr}));
    if (!file) throw std::bad_alloc();
    const std::unique_ptr<t_ply_, ClosePly> ply(
        ply_open_from_file(file.get(), note_error, 0, this));
    if (!ply) throw std::bad_alloc();
    if (ply_read_header(ply.get()) == 0) return fail(std::move(error_));
    for (auto* element = ply_get_next_element(ply.get(), nullptr); element != nullptr;
         element = ply_get_next_element(ply.get(), element)) {
      if (const auto checked = check(ply.get(), element); !checked) return fail(checked.error());
    }
    if (ply_read(ply.get()) == 0) return fail(std::move(error_));
    return std::move(soup_).triangulated(findings);
  }

 private:
  static PlyReader& reader_of(p_ply_argument argument, long* role = nullptr) {
    void* reader = nullptr;
    ply_get_argument_user_data(argument, &reader, role);
    return *static_cast<PlyReader*>(reader);
  }

  // First what, then where; or what rply says of our own error.
  static void note_error(p_ply ply, const char* message) {
    void* reader = nullptr;
    ply_get_ply_user_data(ply, &reader, nullptr);
    auto& self = *static_cast<PlyReader*>(reader);
    if (self.is_stopped_) return;
    std::string& detail = self.error_.detail;
    if (!detail.empty()) detail.back() = ':';
    detail += (detail.empty() ? "PLY: " : " ") + printable(message) + ".";
    self.error_.code = ErrorCode::mesh_invalid;
  }

  // What an element claims, before memory is taken for any; and who wants its values.
  Result<void> check(p_ply ply, p_ply_element element) {
    const char* name = nullptr;
    long count = 0;
    ply_get_element_info(element, &name, &count);
    const std::string text = "The PLY element " + printable(name);
    const bool is_vertex = std::string_view(name) == "vertex";
    const bool is_face = std::string_view(name) == "face";
    std::uint64_t least = 0;
    int wanted = 0;
    std::vector<std::string_view> ours;
    for (auto* property = ply_get_next_property(element, nullptr); property != nullptr;
         property = ply_get_next_property(element, property)) {
      const char* property_name = nullptr;
      e_ply_type type{};
      e_ply_type length{};
      e_ply_type value{};
      ply_get_property_info(property, &property_name, &type, &length, &value);
      const bool is_list = type == PLY_LIST;
      // rply takes a list for the one, a number with a fraction for the other.
      if (is_list && (value == PLY_LIST || !is_integer(length))) {
        return invalid(text + " has a list of lists, or one whose length is no integer: " +
                       printable(property_name) + ".");
      }
      // A word of a text takes two bytes with the blank after it, but for the last.
      least += is_text_ ? 2 : size_of(is_list ? length : type);
      const std::string_view role = property_name;
      const bool is_axis = is_vertex && (role == "x" || role == "y" || role == "z");
      const bool is_corners = is_face && (role == "vertex_indices" || role == "vertex_index");
      if (!is_axis && !is_corners) continue;
      // rply knows them by name, and takes the first.
      if (std::ranges::count(ours, role) != 0) {
        return invalid(text + " has " + std::string(role) + " twice.");
      }
      ours.push_back(role);
      if (is_axis && !is_list) {
        ply_set_read_cb(ply, name, property_name, on_coordinate, this, role[0] - 'x');
        ++wanted;
      }
      if (is_corners && is_list && wanted++ == 0) {
        ply_set_read_cb(ply, name, property_name, on_corner, this, 0);
      }
    }
    if (is_vertex && wanted != 3) return invalid(text + " lacks x, y or z.");
    if (is_face && wanted == 0) return invalid(text + " has no list vertex_indices.");
    if (count > 0 && least == 0) return invalid(text + " has no properties.");
    if (count > 0 && static_cast<std::uint64_t>(count) > (bytes_left_ + 1) / least) {
      return invalid(text + " claims " + std::to_string(count) + " of at least " +
                     std::to_string(least) + " bytes, but " + std::to_string(bytes_left_) +
                     " bytes are left.");
    }
    bytes_left_ -= std::min(bytes_left_, static_cast<std::uint64_t>(count) * least);
    return {};
  }

  static tl::unexpected<Error> invalid(std::string what) {
    return fail(ErrorCode::mesh_invalid, std::move(what));
  }

  // C calls these: no exception may pass through it. 0 has it stop.
  template <class Step>
  int attempt(const Step& step) {
    try {
      const Result<void> done = step();
      if (done) return 1;
      error_ = done.error();
    } catch (const std::bad_alloc&) {
      error_ =
          fail(ErrorCode::too_large, "Decoding the mesh needs more memory than there is.").value();
    }
    is_stopped_ = true;
    return 0;
  }

  static tl::unexpected<Error> invalid(p_ply_argument argument, const char* element,
                                       const std::string& what) {
    long number = 0;
    ply_get_argument_element(argument, nullptr, &number);
    return invalid(std::string(element) + " " + std::to_string(number) + ": " + what);
  }

  static int on_coordinate(p_ply_argument argument) {
    long axis = 0;
    PlyReader& self = reader_of(argument, &axis);
    return self.attempt([&] { return self.coordinate(argument, axis); });
  }

  static int on_corner(p_ply_argument argument) {
    PlyReader& self = reader_of(argument);
    return self.attempt([&] { return self.corner(argument); });
  }

  // Each vertex has each of its coordinates once, in the order of its properties.
  Result<void> coordinate(p_ply_argument argument, long axis) {
    const double value = ply_get_argument_value(argument);
    if (!std::isfinite(value)) {
      return invalid(argument, "vertex", "a coordinate is no finite number.");
    }
    (axis == 0 ? position_.x : axis == 1 ? position_.y : position_.z) = value;
    if (++coordinates_ % 3 != 0) return {};
    return soup_.add_vertex(position_);
  }

  // First the length, at -1, then that many corners.
  Result<void> corner(p_ply_argument argument) {
    long length = 0;
    long at = 0;
    ply_get_argument_property(argument, nullptr, &length, &at);
    if (at < 0) {
      corners_.clear();
      // rply counts them in an int.
      if (length >= 3 && length <= std::numeric_limits<int>::max()) return {};
      return invalid(argument, "face", "it has " + std::to_string(length) + " corners.");
    }
    const double value = ply_get_argument_value(argument);
    if (!(value >= 0 && value <= std::numeric_limits<std::uint32_t>::max()) ||
        value != std::floor(value)) {
      return invalid(argument, "face", "a corner names no vertex.");
    }
    corners_.push_back(static_cast<std::uint32_t>(value));
    if (at + 1 < length) return {};
    return soup_.add_face(corners_);
  }

  Pieces pieces_;
  std::uint64_t bytes_left_;
  bool is_text_;
  PolygonSoup soup_;
  Error error_;
  bool is_stopped_ = false;  // by an error of ours
  Vec3 position_{};
  std::uint64_t coordinates_ = 0;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Result<DecodedMesh> decode_ply(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const auto header = clean_ply_header({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!header) return fail(header.error());
  Findings findings;
  if (header->has_strips) findings.add("strips_left_out", "element tristrips", "is not read");
  auto soup = PlyReader(*header, limits).run(findings);
  if (!soup) return fail(std::move(soup.error()));
  DecodedMesh mesh = mesh_of_one_part(MeshFormat::ply, std::move(*soup));
  mesh.findings = findings.done();
  return mesh;
}

}  // namespace geodesic::proto
