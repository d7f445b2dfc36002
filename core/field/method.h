// The ways to a distance field that this library knows, what holds of each, and what can be asked
// of them. One `switch` in solve_field.cpp tells them apart.
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

// What holds of all fields by a method.
struct MethodTraits {
  // They say of each vertex where its distance came from (`Field::parents`). Without parents a path
  // goes back by distances, through whichever face leads to the least.
  bool has_parents = false;
  // These distances are approximate, and nothing else is there to go by: they may lead a path
  // astray, or to nowhere. It goes along edges then.
  bool may_lead_astray = false;
  // They are a metric: from a to b it is as far as from b to a, and no farther than by way of c.
  bool are_metric = false;
  // A source has a wave of its own, and the nearest is taken. So many sources take long.
  bool has_wave_for_each_source = false;
  // They can keep windows (`Field::windows`), by which a point inside a face has its distance.
  bool has_windows = false;
  // They can keep the points that are added to edges (`Field::edge_points`), for the same end.
  bool has_edge_points = false;

  // Whether they are larger with `FieldLimits::keep_details`.
  [[nodiscard]] constexpr bool has_details() const { return has_windows || has_edge_points; }
};

// The table of these traits, a row a method.
[[nodiscard]] constexpr MethodTraits traits_of(Method method) {
  switch (method) {
    case Method::wavefront:
    case Method::novotni:
      return {.has_parents = true, .has_wave_for_each_source = true};
    case Method::dijkstra:
      return {.has_parents = true, .are_metric = true};
    case Method::fast_marching:
    case Method::back_traced:
      return {.may_lead_astray = true};
    case Method::steiner:
      return {.are_metric = true, .has_edge_points = true};
    case Method::exact:
    case Method::chen_han:
      return {.are_metric = true, .has_windows = true};
  }
  return {};
}

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
