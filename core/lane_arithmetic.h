// Arithmetic on four lanes at once, by the vector extensions of GCC and Clang, which cut
// it into registers of whatever size there are.
//
// Functions over these types are inlined by force into one function per kind of
// instructions, which alone says what it is compiled for. Vectors go by reference: how
// they are passed by value depends on the instructions.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#define GEODESIC_LANES_INLINE inline __attribute__((always_inline))

namespace geodesic::lanes {

constexpr std::size_t kWide = 4;
using Reals = double __attribute__((vector_size(kWide * sizeof(double))));
using Floats = float __attribute__((vector_size(kWide * sizeof(float))));
// Of a comparison: all bits of a lane or none.
using Flags = std::int64_t __attribute__((vector_size(kWide * sizeof(std::int64_t))));
using Ids = std::uint32_t __attribute__((vector_size(kWide * sizeof(std::uint32_t))));

// Of numbers that are not negative.
GEODESIC_LANES_INLINE void root(Reals& to, const Reals& of) {
  for (std::size_t i = 0; i < kWide; ++i) to[i] = std::sqrt(of[i]);
}

// The same flags, as wide as ids.
GEODESIC_LANES_INLINE void narrow(Ids& to, const Flags& from) {
  using Halves = std::uint32_t __attribute__((vector_size(sizeof(Flags))));
  Halves halves;
  std::memcpy(&halves, &from, sizeof halves);
  to = __builtin_shufflevector(halves, halves, 0, 2, 4, 6);
}

GEODESIC_LANES_INLINE bool any(const Flags& flags) {
  return (flags[0] | flags[1] | flags[2] | flags[3]) != 0;
}

// Without a branch, and from memory: which corner comes next is anybody's guess.
inline constexpr std::uint8_t kNextCorner[4] = {1, 2, 0, 0};
inline constexpr std::uint8_t kPreviousCorner[4] = {2, 0, 1, 0};

}  // namespace geodesic::lanes
