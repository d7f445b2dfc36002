// Numbers from and to text, without locales.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/field/method.h"

namespace geodesic::proto {

// All of `text` as a finite number, or nothing.
[[nodiscard]] inline std::optional<double> parse_finite(std::string_view text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

// "1,2,3" as finite numbers, or nothing.
[[nodiscard]] inline std::optional<std::vector<double>> numbers_between_commas(
    std::string_view text) {
  std::vector<double> numbers;
  for (;;) {
    const std::size_t comma = text.find(',');
    const auto number = parse_finite(text.substr(0, comma));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
}

// All of `text` as a whole number without a sign, or nothing.
[[nodiscard]] inline std::optional<std::uint64_t> parse_whole(std::string_view text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// Appends a number as JSON: `digits` significant ones, or as few as read back to
// the same value when 0. What is not finite becomes null.
inline void append_number(std::string& out, double value, int digits = 0) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  char text[32];
  const auto result = digits > 0 ? std::to_chars(text, text + sizeof text, value,
                                                 std::chars_format::general, digits)
                                 : std::to_chars(text, text + sizeof text, value);
  out.append(text, result.ptr);
}

// The same of a number that is not to be read as less than it is: with Bound::upper it is rounded
// up to its digits; one below 0 away from 0, too.
inline void append_bound(std::string& out, double value, int digits, Bound bound) {
  if (value < 0 && std::isfinite(value)) {
    out += '-';
    append_bound(out, -value, digits, bound);
    return;
  }
  const std::size_t begin = out.size();
  append_number(out, value, digits);
  if (bound == Bound::none || digits <= 0 || !(std::isfinite(value) && value > 0)) return;
  // Half a unit of the last digit. What is raised by that is, next to it, the number rounded up;
  // where rounding takes it back, one more is enough.
  const double half = 0.5 * std::pow(10.0, std::floor(std::log10(value)) + 1 - digits);
  double raised = value;
  while (parse_finite(std::string_view(out).substr(begin)).value_or(value) < value) {
    raised = std::max(raised + half, std::nextafter(raised, std::numeric_limits<double>::max()));
    out.resize(begin);
    append_number(out, raised, digits);
  }
}

// The same of a distance. With `short_digits`, and without a number of them: where it is a
// float, as few as read back to the same float.
inline void append_distance(std::string& out, double distance, int digits, bool short_digits,
                            Bound bound = Bound::none) {
  const auto narrow = static_cast<float>(distance);
  if (!short_digits || digits > 0 || narrow != distance || !std::isfinite(distance)) {
    append_bound(out, distance, digits, bound);
    return;
  }
  char text[32];
  const auto result = std::to_chars(text, text + sizeof text, narrow);
  out.append(text, result.ptr);
}

}  // namespace geodesic::proto
