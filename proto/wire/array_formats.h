// Arrays of numbers as bytes: bare, with NumPy's header, quantised, and several of
// them in one self-describing frame. All little-endian, in C order.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/method.h"

namespace geodesic::proto {

enum class NumberType : std::uint8_t { f32, f64, u16, u32 };

// NumPy's name for it, such as "<f4".
[[nodiscard]] std::string_view dtype_of(NumberType type);

struct Array {
  std::string name;  // in a frame
  NumberType type = NumberType::f64;
  std::vector<std::uint64_t> shape;
  std::string bytes;
};

// These are cut short if the poll, where there is one, says to stop.
// Rounded to the next float, of finite numbers beyond them the largest; with Bound::upper to the
// next that is not below, infinity if need be.
[[nodiscard]] std::string f32_bytes(std::span<const double> values, Bound bound = Bound::none,
                                    Poll* poll = nullptr);
[[nodiscard]] std::string f64_bytes(std::span<const double> values, Poll* poll = nullptr);
[[nodiscard]] std::string u32_bytes(std::span<const std::uint32_t> values, Poll* poll = nullptr);
// Values from 0 to `max` as whole numbers from 0 to 65534, rounded; infinite ones
// as 65535. With a `max` of zero every finite value is 0. With Bound::upper they are rounded up:
// none is below what it stands for.
[[nodiscard]] std::string u16_bytes(std::span<const double> values, double max,
                                    Bound bound = Bound::none, Poll* poll = nullptr);

// NumPy's .npy, version 1.0, and what is before the array in it. `dtype`: NumPy's name.
[[nodiscard]] std::string npy(const Array& array);
[[nodiscard]] std::string npy_header(std::string_view dtype, std::span<const std::uint64_t> shape);

// A frame: a header of 24 bytes (`GEOD`, u32 version = 1, u32 length of the JSON,
// u32 flags = 0, u64 length of the whole), the JSON, padded with spaces so that what
// follows is at a multiple of 8, and the arrays, each at a multiple of 8. `about` is
// an object; the JSON is that, with
//   "arrays": [{"name", "dtype", "shape", "offset", "nbytes"}, ...]
// added, where offsets count from the frame's first byte.
[[nodiscard]] std::string frame(const nlohmann::ordered_json& about, std::span<const Array> arrays);

}  // namespace geodesic::proto
