// Faces on one edge, or at one vertex, by the ten thousands.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/mesh/triangle_soup.h"
#include "tests/fixtures/sanitizers.h"

namespace crowded {

using geodesic::Triangle;
using geodesic::TriangleSoup;

// So many that their square is told from their number; sanitizers look for something else.
inline constexpr std::uint32_t kFaces = geodesic::fixtures::all_or(10'000, 2'000);

inline TriangleSoup copies(double height) {
  return {{{0, 0, 0}, {1, 0, 0}, {0.4, height, 0}}, std::vector<Triangle>(kFaces, {0, 1, 2})};
}

// Pages of `rows` rows of two faces on one edge from 0 to 1, each with its own vertices.
inline TriangleSoup book(std::uint32_t pages, std::uint32_t rows) {
  TriangleSoup soup{{{0, 0, 0}, {0, 1, 0}}, {}};
  for (std::uint32_t p = 0; p < pages; ++p) {
    const double angle = 2 * std::numbers::pi * p / pages;
    std::uint32_t low = 0;
    std::uint32_t high = 1;
    for (std::uint32_t r = 1; r <= rows; ++r) {
      const auto next = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.push_back({r * std::cos(angle), 0, r * std::sin(angle)});
      soup.positions.push_back({r * std::cos(angle), 1, r * std::sin(angle)});
      soup.faces.push_back({low, next, high});
      soup.faces.push_back({next, next + 1, high});
      low = next;
      high = next + 1;
    }
  }
  return soup;
}

inline TriangleSoup fan() {
  TriangleSoup soup{{{0, 0, 0.1}}, {}};
  for (std::uint32_t i = 0; i < kFaces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kFaces;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0});
    soup.faces.push_back({0, 1 + i, 1 + (i + 1) % kFaces});
  }
  return soup;
}

struct Crowd {
  std::string name;
  TriangleSoup soup;
};

inline std::vector<Crowd> crowds() {
  return {{"copies of a triangle", copies(0.7)},
          {"copies of a thin one", copies(1e-9)},
          {"a book of single rows", book(kFaces / 2, 1)},
          {"a book of four rows", book(kFaces / 8, 4)},
          {"a fan", fan()}};
}

}  // namespace crowded
