// The ways to a distance field that this library knows, and what can be asked of
// them. One `switch` in solve_field.cpp tells them apart.
#pragma once

#include <cstdint>
#include <optional>

namespace geodesic {

enum class Method : std::uint8_t {
  wavefront,      // Tang, Wu, Zhang, Zhang 2007
  novotni,        // Novotni, Klein 2002
  fast_marching,  // Kimmel, Sethian 1998
  dijkstra,       // along the edges
  steiner,        // Kanai, Suzuki 2001
  exact,          // Mitchell, Mount, Papadimitriou 1987; Surazhsky et al. 2005
  chen_han,       // Chen, Han 1996; Xin, Wang 2009
  back_traced,    // the paper's wavefront, looking back; "auto" to clients
};

// What distances may be relative to the true ones.
enum class Bound : std::uint8_t {
  none,   // as near as can be, on either side
  upper,  // not below: the lengths of paths
};

struct MethodOptions {
  // steiner: points added inside each edge, evenly spaced. At least 1.
  std::uint32_t points_per_edge = 3;
  // steiner: a path is refined until a round shortens it by less than this part of
  // its length.
  double tolerance = 1e-4;
  // back_traced
  Bound bound = Bound::none;
  // back_traced: the largest relative error that a vertex's distance may have, from 0 to 1;
  // it is above the true one then, whatever the bound. None: as it comes, and soonest.
  std::optional<double> error_at_most = std::nullopt;

  [[nodiscard]] friend bool operator==(const MethodOptions&, const MethodOptions&) = default;
};

}  // namespace geodesic
