// Digits of five by seven pixels, for the scale beside a picture.
#pragma once

#include <array>
#include <cstdint>

namespace geodesic::proto {

inline constexpr std::uint32_t kDigitWidth = 5;
inline constexpr std::uint32_t kDigitHeight = 7;

// Rows from the top, the leftmost pixel in bit 4. Characters that no number has
// are blank.
[[nodiscard]] constexpr std::array<std::uint8_t, kDigitHeight> digit_rows(char c) {
  switch (c) {
    case '0':
      return {14, 17, 17, 17, 17, 17, 14};
    case '1':
      return {4, 12, 4, 4, 4, 4, 14};
    case '2':
      return {14, 17, 1, 2, 4, 8, 31};
    case '3':
      return {31, 2, 4, 2, 1, 17, 14};
    case '4':
      return {2, 6, 10, 18, 31, 2, 2};
    case '5':
      return {31, 16, 30, 1, 1, 17, 14};
    case '6':
      return {6, 8, 16, 30, 17, 17, 14};
    case '7':
      return {31, 1, 2, 4, 8, 8, 8};
    case '8':
      return {14, 17, 17, 14, 17, 17, 14};
    case '9':
      return {14, 17, 17, 15, 1, 2, 12};
    case '.':
      return {0, 0, 0, 0, 0, 12, 12};
    case '-':
      return {0, 0, 0, 31, 0, 0, 0};
    case '+':
      return {0, 4, 4, 31, 4, 4, 0};
    case 'e':
      return {0, 0, 14, 17, 31, 16, 14};
    default:
      return {};
  }
}

}  // namespace geodesic::proto
