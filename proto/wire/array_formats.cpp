#include "proto/wire/array_formats.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

namespace geodesic::proto {
namespace {

// Numbers are copied as they lie in memory.
static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kFrameHeader = 24;
constexpr std::uint32_t kFrameVersion = 1;

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

template <class To, class From, class Convert>
std::string converted(std::span<const From> values, Poll* poll, Convert convert) {
  std::string bytes(values.size() * sizeof(To), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (poll != nullptr && poll->cancelled()) break;
    const To value = convert(values[i]);
    std::memcpy(bytes.data() + i * sizeof(To), &value, sizeof(To));
  }
  return bytes;
}

std::size_t rounded_up(std::size_t size, std::size_t multiple) {
  return (size + multiple - 1) / multiple * multiple;
}

}  // namespace

std::string_view dtype_of(NumberType type) {
  switch (type) {
    case NumberType::f32:
      return "<f4";
    case NumberType::u16:
      return "<u2";
    case NumberType::u32:
      return "<u4";
    case NumberType::f64:
      break;
  }
  return "<f8";
}

std::string f32_bytes(std::span<const double> values, Bound bound, Poll* poll) {
  if (bound == Bound::none) {
    return converted<float>(values, poll, [](double value) {
      // Costs may be larger than any float. Infinite would say that there is no way.
      constexpr double kLargest = std::numeric_limits<float>::max();
      return static_cast<float>(std::isfinite(value) ? std::min(value, kLargest) : value);
    });
  }
  return converted<float>(values, poll, [](double value) {
    const auto next = static_cast<float>(value);
    if (!(std::abs(next) < std::abs(value))) return next;
    return std::nextafter(next, std::copysign(std::numeric_limits<float>::infinity(), next));
  });
}

std::string f64_bytes(std::span<const double> values, Poll* poll) {
  return converted<double>(values, poll, [](double value) { return value; });
}

std::string u32_bytes(std::span<const std::uint32_t> values, Poll* poll) {
  return converted<std::uint32_t>(values, poll, [](std::uint32_t value) { return value; });
}

std::string u16_bytes(std::span<const double> values, double max, Bound bound, Poll* poll) {
  constexpr long kMost = 65534;
  const double scale = max > 0 ? kMost / max : 0;
  if (bound == Bound::none) {
    return converted<std::uint16_t>(values, poll, [scale](double value) {
      return static_cast<std::uint16_t>(std::isfinite(value) ? std::lround(value * scale) : 65535);
    });
  }
  const double step = max / kMost;
  return converted<std::uint16_t>(values, poll, [=](double value) {
    if (!std::isfinite(value)) return std::uint16_t{65535};
    long steps = std::clamp(std::lround(value * scale), 0L, kMost);
    // However a client computes it.
    const auto is_below = [&](long n) {
      return static_cast<double>(n) * step < value || static_cast<double>(n) / kMost * max < value;
    };
    while (steps < kMost && is_below(steps)) ++steps;
    return static_cast<std::uint16_t>(steps);
  });
}

// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
std::string npy(const Array& array) {
  return npy_header(dtype_of(array.type), array.shape) + array.bytes;
}

std::string npy_header(std::string_view dtype, std::span<const std::uint64_t> shape) {
  std::string header = "{'descr': '";
  header += dtype;
  header += "', 'fortran_order': False, 'shape': (";
  for (const std::uint64_t count : shape) header += std::to_string(count) + ",";
  header += "), }";
  constexpr std::size_t kPreamble = 10;  // magic, version and the header's length
  header.resize(rounded_up(kPreamble + header.size() + 1, 64) - kPreamble - 1, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  append(bytes, static_cast<std::uint16_t>(header.size()));
  return bytes + header;
}

std::string frame(const nlohmann::ordered_json& about, std::span<const Array> arrays) {
  const auto json_at = [&](std::size_t begin, std::size_t& end) {
    nlohmann::ordered_json json = about;
    auto& list = json["arrays"] = nlohmann::ordered_json::array();
    end = begin;
    for (const Array& array : arrays) {
      list.push_back({{"name", array.name},
                      {"dtype", dtype_of(array.type)},
                      {"shape", array.shape},
                      {"offset", end},
                      {"nbytes", array.bytes.size()}});
      end = rounded_up(end + array.bytes.size(), 8);
    }
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  };
  // The offsets are in the JSON whose length they depend on: more room until it fits.
  std::size_t begin = kFrameHeader;
  std::size_t end = 0;
  std::string json = json_at(begin, end);
  while (kFrameHeader + json.size() > begin) {
    begin = rounded_up(kFrameHeader + json.size(), 8);
    json = json_at(begin, end);
  }
  json.resize(begin - kFrameHeader, ' ');

  std::string bytes = "GEOD";
  bytes.reserve(end);
  append(bytes, kFrameVersion);
  append(bytes, static_cast<std::uint32_t>(json.size()));
  append(bytes, std::uint32_t{0});
  append(bytes, static_cast<std::uint64_t>(end));
  bytes += json;
  for (const Array& array : arrays) {
    bytes += array.bytes;
    bytes.resize(rounded_up(bytes.size(), 8), '\0');
  }
  return bytes;
}

}  // namespace geodesic::proto
