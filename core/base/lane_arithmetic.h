// Arithmetic on a few lanes at once, by the vector extensions of GCC and Clang.
//
// As many lanes as the registers of the instructions at hand hold: wider vectors are cut
// up, and their comparisons and choices lane by lane, with branches. Functions over these
// types are inlined by force into one function per kind of instructions, which alone says
// what it is compiled for. Vectors go by reference: how they are passed by value depends
// on the instructions.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#define GEODESIC_LANES_INLINE inline __attribute__((always_inline))

namespace geodesic::lanes {

// The size of a vector must not depend on a template's parameter.
template <std::size_t kWide>
struct Vector;
template <>
struct Vector<2> {
  using Reals = double __attribute__((vector_size(16)));
  using Flags = std::int64_t __attribute__((vector_size(16)));
  using Ids = std::uint64_t __attribute__((vector_size(16)));
};
template <>
struct Vector<4> {
  using Reals = double __attribute__((vector_size(32)));
  using Flags = std::int64_t __attribute__((vector_size(32)));
  using Ids = std::uint64_t __attribute__((vector_size(32)));
};

template <class Values>
struct HalfOf;
template <>
struct HalfOf<Vector<4>::Reals> {
  using type = Vector<2>::Reals;
};
template <>
struct HalfOf<Vector<4>::Ids> {
  using type = Vector<2>::Ids;
};

template <std::size_t kWide>
struct Lanes {
  using Reals = typename Vector<kWide>::Reals;
  // Of a comparison: all bits of a lane or none.
  using Flags = typename Vector<kWide>::Flags;
  // Each in the low half of a lane.
  using Ids = typename Vector<kWide>::Ids;

  // Of numbers that are not negative.
  static GEODESIC_LANES_INLINE void root(Reals& to, const Reals& of) {
    for (std::size_t i = 0; i < kWide; ++i) to[i] = std::sqrt(of[i]);
  }

  // What `at` tells for each lane.
  template <class Values, class At>
  static GEODESIC_LANES_INLINE void gather(Values& to, At at) {
    if constexpr (kWide == 2) {
      to = Values{at(0), at(1)};
    } else {
      static_assert(kWide == 4);
      // By halves, which compilers make of fewer steps.
      using Half = typename HalfOf<Values>::type;
      const Half low{at(0), at(1)};
      const Half high{at(2), at(3)};
      to = __builtin_shufflevector(low, high, 0, 1, 2, 3);
    }
  }

  // `yes` in the lanes of `flags`, else `no`. Bit by bit where compilers do not know that a
  // flag, other than a comparison, is all bits or none, and would ask at some length.
  template <class Values>
  static GEODESIC_LANES_INLINE void choose(Values& to, const Flags& flags, const Values& yes,
                                           const Values& no) {
    if constexpr (kWide == 2) {
      to = (Values)((flags & (Flags)yes) | (~flags & (Flags)no));
    } else {
      to = flags ? yes : no;
    }
  }

  static GEODESIC_LANES_INLINE bool any(const Flags& flags) {
    std::int64_t all = 0;
    for (std::size_t i = 0; i < kWide; ++i) all |= flags[i];
    return all != 0;
  }
};

// Of the registers that every processor of the kind has, and of those of AVX2.
constexpr std::size_t kPlain = 2;
constexpr std::size_t kWithAvx2 = 4;

// Without a branch, and from memory: which corner comes next is anybody's guess.
inline constexpr std::uint8_t kNextCorner[4] = {1, 2, 0, 0};
inline constexpr std::uint8_t kPreviousCorner[4] = {2, 0, 1, 0};

}  // namespace geodesic::lanes
