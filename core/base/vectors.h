// Which vector instructions the lanes of back traces and arrivals are computed with.
#pragma once

#include <cstdint>

namespace geodesic {

// `plain` are those that every processor of the kind has: SSE2, NEON. Others than this
// processor's must not be asked for.
enum class Vectors : std::uint8_t { plain, avx2, avx512 };

// The best of those that this processor has.
[[nodiscard]] inline Vectors best_vectors() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    return Vectors::avx512;
  }
  if (__builtin_cpu_supports("avx2")) return Vectors::avx2;
#endif
  return Vectors::plain;
}

}  // namespace geodesic
