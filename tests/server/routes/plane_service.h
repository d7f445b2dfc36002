// The service with one mesh, a plane of 12 x 10 vertices one apart, and what
// every error reply has in common.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fixtures/awkward_meshes.h"
#include "tests/server/routes/service_fixture.h"

namespace geodesic::server::test {

inline void check_problem(const HttpResponse& response, int status, std::string_view code,
                          std::string_view parameter = {}) {
  CHECK(response.status == status);
  REQUIRE(response.content_type == "application/problem+json");
  const json problem = body_of(response);
  CHECK(problem["code"] == code);
  CHECK(problem["status"] == status);
  CHECK(problem["request_id"] == "test");
  CHECK(problem.value("parameter", "") == parameter);
  CHECK_FALSE(problem["detail"].get<std::string>().empty());
}

struct PlaneService {
  explicit PlaneService(const Config& config = {}, std::size_t slots = 2)
      : service(folder.path(), config, slots) {}

  void check_refused_upload(const std::string& bytes, int status, std::string_view code) {
    check_problem(service.ask("POST", "/v1/meshes", bytes), status, code);
    CHECK(service.store->size() == 1);
    CHECK(folder.files().size() == 3);  // the lock, and the plane's two
  }
  // The JSON of a query that succeeds.
  json ask(const std::string& target) {
    const HttpResponse response = service.get(base + target);
    CAPTURE(target);
    REQUIRE(response.status == 200);
    return body_of(response);
  }
  void check_refused(const std::string& target, int status, std::string_view code,
                     std::string_view parameter) {
    CAPTURE(target);
    check_problem(service.get(base + target), status, code, parameter);
  }
  // GET and POST give the same bytes.
  void check_same(const std::string& target, const std::string& body) {
    CAPTURE(target);
    const std::string path = target.substr(0, target.find('?'));
    const HttpResponse get = service.get(base + target);
    const HttpResponse post = service.ask("POST", base + path, body);
    REQUIRE(get.status == 200);
    REQUIRE(post.status == 200);
    CHECK(*get.body == *post.body);
  }
  // The base of another mesh.
  std::string add(const TriangleSoup& soup) { return "/v1/meshes/" + service.upload(glb_of(soup)); }

  TemporaryFolder folder;
  Service service;
  std::string id = service.upload(glb_of(shapes::plane(12, 10)));
  std::string base = "/v1/meshes/" + id;
};

// The sum of a polyline's segments, from `points` of a reply ({xyz} or [x,y,z]).
inline double length_of(const json& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto at = [&](std::size_t k) {
      const json& p = points[k].is_array() ? points[k] : points[k]["xyz"];
      return Vec3{p[0].get<double>(), p[1].get<double>(), p[2].get<double>()};
    };
    length += distance(at(i), at(i - 1));
  }
  return length;
}

}  // namespace geodesic::server::test
