#include "proto/encode/npz.h"

#include <zlib.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/wire/array_formats.h"

namespace geodesic::proto {
namespace {

// By PKWARE's APPNOTE.TXT 6.3.10, sections 4.3.7, 4.3.12 and 4.3.16.
constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::uint32_t kDirectoryHeader = 0x02014b50;
constexpr std::uint32_t kDirectoryEnd = 0x06054b50;
constexpr std::uint16_t kVersion = 20;
constexpr std::uint16_t kFirstOfJanuary1980 = 0x21;

template <class Number>
void put(std::string& bytes, Number value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

std::uint32_t checksum_of(std::string_view header, std::string_view rest) {
  const auto add = [](uLong crc, std::string_view bytes) {
    return crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  };
  return static_cast<std::uint32_t>(add(add(crc32_z(0, nullptr, 0), header), rest));
}

// A file of members that are not compressed.
class StoredZip {
 public:
  explicit StoredZip(std::size_t bytes) { file_.reserve(bytes); }

  // One array, in two parts.
  void add(std::string_view name, std::string_view header, std::string_view array) {
    std::string entry;  // what both headers of a member say
    put(entry, kVersion);
    put(entry, std::uint16_t{0});  // no flags
    put(entry, std::uint16_t{0});  // stored
    put(entry, std::uint16_t{0});  // at midnight
    put(entry, kFirstOfJanuary1980);
    put(entry, checksum_of(header, array));
    const auto size = static_cast<std::uint32_t>(header.size() + array.size());
    put(entry, size);  // compressed
    put(entry, size);
    put(entry, static_cast<std::uint16_t>(name.size()));
    put(entry, std::uint16_t{0});  // nothing extra

    put(directory_, kDirectoryHeader);
    put(directory_, kVersion);
    directory_ += entry;
    put(directory_, std::uint16_t{0});  // no comment
    put(directory_, std::uint16_t{0});  // on the first disk
    put(directory_, std::uint16_t{0});
    put(directory_, std::uint32_t{0});
    put(directory_, static_cast<std::uint32_t>(file_.size()));
    directory_ += name;
    ++members_;

    put(file_, kLocalHeader);
    file_ += entry;
    file_ += name;
    file_ += header;
    file_ += array;
  }

  [[nodiscard]] std::string finish() && {
    const auto begin = static_cast<std::uint32_t>(file_.size());
    file_ += directory_;
    put(file_, kDirectoryEnd);
    put(file_, std::uint32_t{0});  // the first disk, twice
    put(file_, members_);
    put(file_, members_);
    put(file_, static_cast<std::uint32_t>(directory_.size()));
    put(file_, begin);
    put(file_, std::uint16_t{0});  // no comment
    return std::move(file_);
  }

 private:
  std::string file_;
  std::string directory_;
  std::uint16_t members_ = 0;
};

template <class Number>
std::string raw(std::span<const Number> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

}  // namespace

std::string npz(const SparseEntries& entries, const std::array<std::uint64_t, 2>& shape) {
  constexpr std::size_t kHeaders = 4096;
  const std::uint64_t count = entries.count();
  const std::string begins = raw(std::span<const std::uint32_t>(entries.begins));
  StoredZip zip(entries.columns.size() + entries.distances.size() + begins.size() + kHeaders);
  const auto add = [&](std::string_view name, std::string_view dtype,
                       const std::vector<std::uint64_t>& sides,
                       std::string_view array) { zip.add(name, npy_header(dtype, sides), array); };
  add("indices.npy", "<i4", {count}, entries.columns);
  add("indptr.npy", "<i4", {entries.begins.size()}, begins);
  add("format.npy", "|S3", {}, "csr");
  add("shape.npy", "<i8", {shape.size()}, raw(std::span<const std::uint64_t>(shape)));
  add("data.npy", "<f8", {count}, entries.distances);
  return std::move(zip).finish();
}

}  // namespace geodesic::proto
