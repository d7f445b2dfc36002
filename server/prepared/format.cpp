#include "server/prepared/format.h"

#define XXH_INLINE_ALL
#ifndef NDEBUG
#define XXH_NO_INLINE_HINTS 1  // else it does not compile with -Og
#endif
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>

#include "core/mesh/mesh.h"
#include "core/surface/intrinsic_delaunay.h"
#include "core/surface/refined_surface.h"
#include "server/base/durable_file.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kAlignment = 64;                 // of each array: a FaceRecord's
constexpr std::size_t kAtOnce = std::size_t{1} << 20;  // bytes between two calls of `stop`
constexpr std::array<char, 8> kMagic{'g', 'e', 'o', 'p', 'r', 'e', 'p', '1'};
constexpr std::size_t kArrays = 19;

// What a triangulation consists of besides arrays.
struct DelaunayNumbers {
  std::uint64_t flips;
  double longest2;
  std::uint8_t is_oriented, is_crowded, is_even, has_flat_faces;  // 0 or 1
};

// What a prepared mesh consists of besides arrays.
struct Numbers {
  std::uint64_t zero_area_faces;
  Box box;
  double area;
  TopologyReport report;
  double longest2;
  // 0 or 1.
  std::uint8_t is_oriented, is_even, has_flat_faces, has_lines, is_crowded, is_rough,
      has_large_faces;
  std::uint8_t has_delaunay, has_refined;
  DelaunayNumbers delaunay, refined;
};

struct alignas(kAlignment) Head {
  std::array<char, 8> magic;
  std::array<std::byte, 16> checksum;  // of all bytes behind it
  std::array<char, 128> mesh;          // the rest of both is zeros
  std::array<char, 64> engine;
  std::uint64_t bytes;  // of all
  std::array<std::uint64_t, kArrays> counts;
  Numbers numbers;
};
static_assert(std::is_trivially_copyable_v<Head>);
constexpr std::size_t kNotCovered = offsetof(Head, checksum) + sizeof(Head::checksum);

// What a prepared mesh consists of; of what it has not, no arrays.
struct PreparedParts {
  Mesh::Parts mesh;
  Adjacency::Parts surface;
  IntrinsicDelaunay::Parts delaunay;
  IntrinsicDelaunay::Parts refined;
  SharedArray<std::uint32_t> first_corner;  // as in RefinedSurface
  SharedArray<double> first_direction;
};

PreparedParts parts_of(const Adjacency& adjacency) {
  PreparedParts parts{adjacency.mesh().parts(), adjacency.parts(), {}, {}, {}, {}};
  if (parts.surface.delaunay) parts.delaunay = parts.surface.delaunay->parts();
  if (adjacency.refined() != nullptr) {
    const auto& [refined, first_corner, first_direction] = adjacency.refined()->parts();
    parts.refined = refined.parts();
    parts.first_corner = first_corner;
    parts.first_direction = first_direction;
  }
  return parts;
}

// All arrays, in the order in which they are written: the same for writing and for reading. Parts
// are named one by one, so that this does not compile when one is added; numbers among them are
// copied in head_of() and read_prepared().
template <class DelaunayParts, class Visit>
void each_array_of(DelaunayParts& delaunay, Visit&& visit) {
  [[maybe_unused]] auto& [faces, corner_begin, corners, is_oriented, is_crowded, is_even,
                          has_flat_faces, longest2, flips] = delaunay;
  visit(faces);
  visit(corner_begin);
  visit(corners);
}

template <class Parts, class Visit>
void each_array(Parts& parts, Visit&& visit) {
  [[maybe_unused]] auto& [positions, triangles, vertex_of_source, source_of_vertex, face_of_source,
                          source_of_face, dropped, zero_area_faces, box, area] = parts.mesh;
  [[maybe_unused]] auto& [faces, corner_begin, corners, pinched, is_oriented, is_even,
                          has_flat_faces, has_lines, is_crowded, is_rough, has_large_faces,
                          longest2, delaunay, refined, report] = parts.surface;
  visit(positions);
  visit(triangles);
  visit(vertex_of_source);
  visit(source_of_vertex);
  visit(face_of_source);
  visit(source_of_face);
  visit(dropped);
  visit(faces);
  visit(corner_begin);
  visit(corners);
  visit(pinched);
  each_array_of(parts.delaunay, visit);
  each_array_of(parts.refined, visit);
  visit(parts.first_corner);
  visit(parts.first_direction);
}

// One by one, for what lies between them in a file is zeros.
void copy_numbers(const IntrinsicDelaunay::Parts& from, DelaunayNumbers& to) {
  to.flips = from.flips;
  to.longest2 = from.longest2;
  to.is_oriented = from.is_oriented;
  to.is_crowded = from.is_crowded;
  to.is_even = from.is_even;
  to.has_flat_faces = from.has_flat_faces;
}

void copy_numbers(const DelaunayNumbers& from, IntrinsicDelaunay::Parts& to) {
  to.flips = from.flips;
  to.longest2 = from.longest2;
  to.is_oriented = from.is_oriented != 0;
  to.is_crowded = from.is_crowded != 0;
  to.is_even = from.is_even != 0;
  to.has_flat_faces = from.has_flat_faces != 0;
}

constexpr std::uint64_t padded(std::uint64_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

template <std::size_t kSize>
void set_text(std::array<char, kSize>& to, std::string_view text) {
  std::copy_n(text.begin(), std::min(text.size(), kSize), to.begin());
}

template <std::size_t kSize>
bool is_text(const std::array<char, kSize>& is, std::string_view text) {
  std::array<char, kSize> wanted{};
  set_text(wanted, text);
  return text.size() <= kSize && is == wanted;
}

Head head_of(const PreparedName& name, const Adjacency& adjacency) {
  Head head;
  std::memset(static_cast<void*>(&head), 0, sizeof(head));  // with what lies between its members
  head.magic = kMagic;
  set_text(head.mesh, name.mesh);
  set_text(head.engine, name.engine);
  const PreparedParts parts = parts_of(adjacency);
  const auto& [mesh, surface, delaunay, refined, first_corner, first_direction] = parts;
  std::size_t at = 0;
  head.bytes = sizeof(Head);
  each_array(parts, [&](const auto& array) {
    head.counts.at(at++) = array.size();
    head.bytes += padded(std::span(array).size_bytes());
  });
  Numbers& numbers = head.numbers;
  numbers.zero_area_faces = mesh.zero_area_faces;
  numbers.box = mesh.box;
  numbers.area = mesh.area;
  numbers.report = surface.report;
  numbers.longest2 = surface.longest2;
  numbers.is_oriented = surface.is_oriented;
  numbers.is_even = surface.is_even;
  numbers.has_flat_faces = surface.has_flat_faces;
  numbers.has_lines = surface.has_lines;
  numbers.is_crowded = surface.is_crowded;
  numbers.is_rough = surface.is_rough;
  numbers.has_large_faces = surface.has_large_faces;
  numbers.has_delaunay = surface.delaunay != nullptr;
  numbers.has_refined = surface.refined != nullptr;
  copy_numbers(delaunay, numbers.delaunay);
  copy_numbers(refined, numbers.refined);
  return head;
}

Result<void> write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return disk_failure("write a prepared mesh", written < 0 ? errno : ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

// Arrays that lie one after another behind the head; nothing if they do not end where they should.
class Arrays {
 public:
  Arrays(std::span<const std::byte> bytes, const Head& head, std::shared_ptr<const void> holder)
      : rest_(bytes.subspan(sizeof(Head))), head_(head), holder_(std::move(holder)) {}

  template <class T>
  void operator()(SharedArray<T>& array) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kAlignment);
    const std::uint64_t count = head_.counts.at(at_++);
    if (count > rest_.size() / sizeof(T) || padded(count * sizeof(T)) > rest_.size()) {
      is_whole_ = false;
      return;
    }
    const auto* const values = reinterpret_cast<const T*>(rest_.data());
    array = SharedArray<T>(std::span(values, static_cast<std::size_t>(count)), holder_);
    rest_ = rest_.subspan(padded(count * sizeof(T)));
  }
  [[nodiscard]] bool is_whole() const { return is_whole_ && rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  const Head& head_;
  const std::shared_ptr<const void> holder_;
  std::size_t at_ = 0;
  bool is_whole_ = true;
};

}  // namespace

struct PreparedChecksum::State {
  XXH3_state_t of_xxh;
};

PreparedChecksum::PreparedChecksum() : state_(std::make_unique<State>()) {
  XXH3_128bits_reset(&state_->of_xxh);
}

PreparedChecksum::~PreparedChecksum() = default;

void PreparedChecksum::add(std::uint64_t offset, std::span<const std::byte> piece) {
  const std::uint64_t before =
      std::min<std::uint64_t>(offset < kNotCovered ? kNotCovered - offset : 0,
                              piece.size());  // not covered
  piece = piece.subspan(before);
  if (!piece.empty()) XXH3_128bits_update(&state_->of_xxh, piece.data(), piece.size());
}

std::array<std::byte, 16> PreparedChecksum::value() const {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(&state_->of_xxh));
  std::array<std::byte, 16> value;
  static_assert(sizeof(canonical) == sizeof(value));
  std::memcpy(value.data(), &canonical, sizeof(value));
  return value;
}

std::uint64_t prepared_bytes(const Adjacency& adjacency) { return head_of({}, adjacency).bytes; }

Result<void> write_prepared(int file, const PreparedName& name, const Adjacency& adjacency,
                            const std::function<bool()>& stop) {
  Head head = head_of(name, adjacency);
  PreparedChecksum checksum;
  std::uint64_t offset = 0;
  Result<void> done;
  const auto append = [&](std::span<const std::byte> bytes) {
    while (done && !bytes.empty()) {
      if (stop()) {
        done = fail(ErrorCode::cancelled, "stopped");
        return;
      }
      const auto piece = bytes.first(std::min(bytes.size(), kAtOnce));
      checksum.add(offset, piece);
      done = write_all(file, piece);
      offset += piece.size();
      bytes = bytes.subspan(piece.size());
    }
  };
  append(std::as_bytes(std::span(&head, 1)));
  const PreparedParts parts = parts_of(adjacency);
  each_array(parts, [&](const auto& array) {
    static constexpr std::array<std::byte, kAlignment> kZeros{};
    const auto bytes = std::as_bytes(std::span(array));
    append(bytes);
    append(std::span(kZeros).first(padded(bytes.size()) - bytes.size()));
  });
  if (!done) return done;
  head.checksum = checksum.value();
  // Last, so that a file whose writing was interrupted fails the check.
  if (::pwrite(file, &head, kNotCovered, 0) != static_cast<ssize_t>(kNotCovered)) {
    return disk_failure("write a prepared mesh", errno);
  }
  return {};
}

std::shared_ptr<const Adjacency> read_prepared(std::span<const std::byte> bytes,
                                               const std::shared_ptr<const void>& holder,
                                               const PreparedName& name,
                                               const PreparedChecksum& checksum) {
  Head head;
  if (bytes.size() < sizeof(head)) return nullptr;
  std::memcpy(&head, bytes.data(), sizeof(head));
  if (head.magic != kMagic || !is_text(head.engine, name.engine) ||
      !is_text(head.mesh, name.mesh) || head.bytes != bytes.size() ||
      head.checksum != checksum.value()) {
    return nullptr;
  }
  PreparedParts parts;
  Arrays arrays(bytes, head, holder);
  each_array(parts, arrays);
  if (!arrays.is_whole()) return nullptr;
  const Numbers& numbers = head.numbers;
  auto& [mesh, surface, delaunay, refined, first_corner, first_direction] = parts;
  mesh.zero_area_faces = static_cast<std::uint32_t>(numbers.zero_area_faces);
  mesh.box = numbers.box;
  mesh.area = numbers.area;
  surface.report = numbers.report;
  surface.is_oriented = numbers.is_oriented != 0;
  surface.is_even = numbers.is_even != 0;
  surface.has_flat_faces = numbers.has_flat_faces != 0;
  surface.has_lines = numbers.has_lines != 0;
  surface.is_crowded = numbers.is_crowded != 0;
  surface.is_rough = numbers.is_rough != 0;
  surface.has_large_faces = numbers.has_large_faces != 0;
  surface.longest2 = numbers.longest2;
  copy_numbers(numbers.delaunay, delaunay);
  copy_numbers(numbers.refined, refined);
  if (numbers.has_delaunay != 0) {
    surface.delaunay = std::make_shared<const IntrinsicDelaunay>(std::move(delaunay));
  }
  if (numbers.has_refined != 0) {
    surface.refined = std::make_shared<const RefinedSurface>(RefinedSurface::Parts{
        IntrinsicDelaunay(std::move(refined)), first_corner, first_direction});
  }
  return std::make_shared<const Adjacency>(std::make_shared<const Mesh>(std::move(mesh)),
                                           std::move(surface));
}

}  // namespace geodesic::server
