// A field of a large mesh, which idle compute slots help with: the reply is the same.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/base/team.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;

TEST_CASE("a reply is the same whether idle slots help or there are none") {
  std::mt19937 random(test_seed());
  constexpr std::uint32_t kSide = 400;
  static_assert(kSide * kSide >= Team::kFewestVertices);
  const std::string glb = glb_of(shapes::terrain(kSide, 30, random()));
  const TemporaryFolder alone_folder;
  const TemporaryFolder helped_folder;
  Service alone(alone_folder.path(), {}, 1);
  Service helped(helped_folder.path(), {}, 3);
  const std::string base = "/v1/meshes/" + alone.upload(glb);
  REQUIRE(helped.upload(glb) == base.substr(std::string("/v1/meshes/").size()));
  std::vector<std::string> all{"",
                               "&bound=upper",
                               "&max=90",
                               "&at=v:77&at=v:12345&at=v:99999",
                               "&method=exact&max=60",
                               "&tolerance=0.01&max=60"};
  std::shuffle(all.begin(), all.end(), random);
  all.resize(fixtures::all_or<std::size_t>(all.size(), 2));
  for (const std::string& rest : all) {
    CAPTURE(rest);
    const std::string target =
        base + "/distance?format=frame&from=v:" + std::to_string(random() % (kSide * kSide)) + rest;
    const HttpResponse expected = alone.get(target);
    const HttpResponse found = helped.get(target);
    REQUIRE(expected.status == 200);
    REQUIRE(found.status == 200);
    CHECK(*found.body == *expected.body);
  }
}
