// What ways are to cost instead of their length, as a client says it, before it is held against a
// mesh (docs: "Weights" and "Slope" in openapi.yaml).
//   in a URL                        in JSON
//   weights=3*faces:7,10-99         {"weights":[{"weight":3,"region":{"faces":[7,[10,99]]}}]}
//   slope=tobler                    {"slope":"tobler"}
//   slope=energy                    {"slope":"energy"}
//   slope=-0.5:2,0:1,0.5:3          {"slope":[[-0.5,2],[0,1],[0.5,3]]}
//   up=0,0,1, steepest=0.6          {"up":[0,0,1],"steepest":0.6}
//   weight_attribute=_MUD           {"weight_attribute":"_MUD"}
// and in JSON {"face_weights":[1,2.5,…]}, one for each source face. Where regions overlap, the one
// that is named last counts.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/field/travel_cost.h"
#include "proto/region/region.h"

namespace geodesic::proto {

struct WeightedRegion {
  Shape shape;
  double weight;
};

struct Costs {
  std::vector<double> face_weights;  // by source face, before regions; empty: 1
  std::string weight_attribute;      // of the file, where they are to be read; empty: none
  std::vector<WeightedRegion> weights;
  TravelCost::Parts walk;  // all of it but the weights

  // Whether ways cost what they are long.
  [[nodiscard]] bool are_lengths() const;
  // Those of the file count before they are read, too.
  [[nodiscard]] bool have_weights() const {
    return !face_weights.empty() || !weight_attribute.empty() || !weights.empty();
  }
  [[nodiscard]] NamedOfFile named_of_file() const;
};

// In what costs are: "seconds" by Tobler's function, "joules_per_kilogram" by energy, "length" in
// mesh units if there is no slope, or else "cost", in the unit of the client's table.
[[nodiscard]] std::string_view unit_of(const Costs& costs);

// Of one mesh, the same for two that ask the same of the same shapes in the same order, and for
// nothing else. Weights of the file go by their attribute: mesh and name decide them, and they may
// be as many as the mesh has faces.
[[nodiscard]] std::string canonical_text(const Costs& costs);

}  // namespace geodesic::proto
