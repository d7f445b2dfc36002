// How much heap memory a piece of work needs at once, counted at every allocation.
// Linking this in replaces the program's operator new and delete.
#pragma once

#include <cstddef>
#include <functional>

namespace geodesic::bench {

// The most bytes that `work` holds at any time beyond what was held before, as the
// allocator hands them out (its rounding included, its own book-keeping not). Not
// to be nested, nor used from two threads.
[[nodiscard]] std::size_t peak_bytes_of(const std::function<void()>& work);

}  // namespace geodesic::bench
