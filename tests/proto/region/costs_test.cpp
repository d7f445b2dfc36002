// The text of costs: the same for what costs the same, and for nothing else.
#include "proto/region/costs.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "proto/region/region.h"

using namespace geodesic;
using namespace geodesic::proto;

TEST_CASE("WeightsOfTheFileGoByTheirAttributeAndThoseSentByTheirNumbers") {
  const auto of_file = [](const std::string& attribute) {
    Costs costs;
    costs.weight_attribute = attribute;
    return costs;
  };
  Costs read = of_file("_MUD");
  read.face_weights.assign(100'000, 1.5);
  CHECK_FALSE(of_file("_MUD").are_lengths());
  CHECK(canonical_text(read) == canonical_text(of_file("_MUD")));
  CHECK(canonical_text(read).size() < 200);
  // Whatever is in a name, it passes for nothing else.
  Costs sent;
  sent.face_weights = {1.5};
  Costs more = of_file("_MUD");
  more.weights.push_back({{std::vector<FaceRange>{{1, 1}}, "weights[0]"}, 3});
  Costs by_label = of_file("_MUD");
  by_label.weights.push_back({{LabelShape{"_MUD", 1}, "weights[0]"}, 3});
  const std::vector<Costs> all{Costs{},
                               sent,
                               of_file("_MUD"),
                               of_file("_MUD2"),
                               of_file("_MUD weight 3 within faces,1-1 forbid"),
                               of_file("faces 1.5"),
                               more,
                               by_label};
  for (const Costs& one : all) {
    for (const Costs& other : all) {
      CHECK((canonical_text(one) == canonical_text(other)) == (&one == &other));
    }
  }
}
