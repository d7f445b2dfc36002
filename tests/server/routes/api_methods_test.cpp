// The methods on offer, and the parameters that each takes and the others refuse.
#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("EveryMethodNamesItsPaperAndAnswers") {
  PlaneService plane;
  const json methods = body_of(plane.service.get("/v1/methods"))["methods"];
  std::set<std::string> names;
  for (const json& method : methods) {
    const std::string name = method["name"];
    CAPTURE(name);
    CHECK(names.insert(name).second);
    CHECK(method["paper"].get<std::string>().size() > 20);
    CHECK_FALSE(method["cost"].get<std::string>().empty());
    CHECK(method["exact"].is_boolean());
    CHECK(method["parameters"].is_array());
    const json field = plane.ask("/distance?from=v:0&method=" + name);
    CHECK(field["method"] == name);
    CHECK(field["reached"] == 120);
    // No method is shorter than the straight line, nor longer than along the edges.
    for (int i = 0; i < 120; ++i) {
      const double straight = std::hypot(i % 12, i / 12);
      const double rounding = name == "auto" ? 1e-7 : 1e-9;  // a float's digits
      CHECK(field["distances"][i] >= doctest::Approx(straight).epsilon(rounding));
      CHECK(field["distances"][i] <= doctest::Approx(1.42 * straight));
      if (method["exact"]) CHECK(field["distances"][i] == doctest::Approx(straight).epsilon(1e-9));
    }
    for (const std::string query :
         {"/table?from=v:0&to=v:50", "/isolines?from=v:0&count=3", "/samples?count=3",
          "/path?from=v:0&to=v:50", "/path?from=v:0&to=v:50&refine=shortest"}) {
      CHECK(plane.ask(query + "&method=" + name)["method"] == name);
    }
  }
  CHECK(names.contains("wavefront"));
  CHECK(names.contains("novotni"));
  CHECK(names.contains("dijkstra"));
}

TEST_CASE("FieldsOfDifferentMethodsAreKeptApart") {
  PlaneService plane;
  const json straight = plane.ask("/distance?from=v:0");
  const HttpResponse along = plane.service.get(plane.base + "/distance?from=v:0&method=dijkstra");
  CHECK(header_of(along, "Geo-Cache") == "miss");
  CHECK(body_of(along)["distances"][22] == doctest::Approx(10 * 1 + std::sqrt(2.0) - 1 + 0));
  CHECK(straight["distances"][22] == doctest::Approx(std::hypot(10, 1)));
}

TEST_CASE("AFieldFromAboveIsNotTheOneThatIsNearest") {
  PlaneService plane;
  const std::string mesh = plane.add(shapes::terrain(30, 6, 2));
  const json exact = body_of(plane.service.get(mesh + "/distance?from=v:0&method=exact"));
  const json nearest = body_of(plane.service.get(mesh + "/distance?from=v:0&method=auto"));
  const HttpResponse reply = plane.service.get(mesh + "/distance?from=v:0&method=auto&bound=upper");
  CHECK(header_of(reply, "Geo-Cache") == "miss");
  const json upper = body_of(reply);
  bool differ = false;
  for (std::size_t v = 0; v < exact["distances"].size(); ++v) {
    const double truth = exact["distances"][v];
    CHECK(upper["distances"][v] >= doctest::Approx(truth).epsilon(1e-9));
    CHECK(upper["distances"][v] <= doctest::Approx(truth).epsilon(0.03));
    CHECK(nearest["distances"][v] == doctest::Approx(truth).epsilon(0.03));
    differ = differ || nearest["distances"][v] != upper["distances"][v];
  }
  CHECK(differ);
}

TEST_CASE("AToleranceIsKeptAndIsAFieldOfItsOwn") {
  PlaneService plane;
  const std::string mesh = plane.add(shapes::terrain(30, 6, 4));
  const json exact = body_of(plane.service.get(mesh + "/distance?from=v:0&method=exact"));
  for (const char* tolerance : {"0.1", "0.001", "1e-5", "0"}) {
    CAPTURE(tolerance);
    const HttpResponse reply = plane.service.get(
        mesh + "/distance?from=v:0&method=auto&tolerance=" + std::string(tolerance));
    CHECK(header_of(reply, "Geo-Cache") == "miss");
    const json within = body_of(reply);
    CHECK(within["method"] == "auto");
    for (std::size_t v = 0; v < exact["distances"].size(); ++v) {
      const double truth = exact["distances"][v];
      const double d = within["distances"][v];
      CHECK(d >= truth * (1 - 1e-11));
      CHECK(d <= truth * (1 + std::stod(tolerance) + 1e-11));
    }
  }
}

TEST_CASE("ParametersThatAMethodDoesNotHaveAreRefused") {
  PlaneService plane;
  plane.check_refused("/distance?from=v:0&points_per_edge=3", 400, "unknown_parameter",
                      "points_per_edge");
  plane.check_refused("/distance?from=v:0&method=wavefront&points_per_edge=3", 400,
                      "unknown_parameter", "points_per_edge");
  plane.check_refused("/distance?from=v:0&method=exact&bound=upper", 400, "unknown_parameter",
                      "bound");
  plane.check_refused("/path?from=v:0&to=v:1&method=dijkstra&tolerance=0.1", 400,
                      "unknown_parameter", "tolerance");
  plane.check_refused("/nearest?point=v:0&method=dijkstra", 400, "unknown_parameter", "method");
}

TEST_CASE("RefusedMethodParametersNameTheWayOut") {
  PlaneService plane;
  const auto detail = [&](const std::string& query) -> std::string {
    return body_of(plane.service.get(plane.base + "/distance?from=v:0&" + query))["detail"];
  };
  CHECK(detail("method=wavefront&bound=upper") ==
        "method=wavefront does not take this, method=auto does");
  CHECK(detail("method=exact&points_per_edge=3") ==
        "method=exact does not take this, method=steiner does");
  CHECK(detail("method=auto&tolerance=0.6") == "this method takes from 0 to 0.5");
  CHECK(detail("method=steiner&points_per_edge=65") == "this method takes from 1 to 64");
  CHECK(detail("method=auto&bound=lower") == "this is none of the choices: none, upper");
  CHECK(detail("deadline_ms=-5") == "this is not a whole number of zero or more");
}

TEST_CASE("EveryMethodParameterHasItsBounds") {
  PlaneService plane;
  const json methods = body_of(plane.service.get("/v1/methods"))["methods"];
  for (const json& method : methods) {
    for (const json& parameter : method["parameters"]) {
      const std::string name = parameter["name"];
      CAPTURE(name);
      const std::string query =
          "from=v:0&method=" + method["name"].get<std::string>() + "&" + name + "=";
      const std::string path = "/path?to=v:50&" + query;
      CHECK_FALSE(parameter["meaning"].get<std::string>().empty());
      if (parameter["for"] == "distances") {
        plane.check_refused(path + "0.1", 400, "unknown_parameter", name);
        CHECK(parameter["default"].is_null());
        for (const std::string bound : {"minimum", "maximum"}) {
          CHECK(plane.ask("/distance?" + query + parameter[bound].dump())["reached"] == 120);
        }
        plane.check_refused("/distance?" + query + "-1e-9", 422, "value_out_of_range", name);
        plane.check_refused("/distance?" + query + "0.6", 422, "value_out_of_range", name);
        continue;
      }
      if (parameter["type"] == "choice") {
        for (const std::string choice : parameter["choices"]) {
          CHECK(plane.ask(path + choice)["reachable"] == true);
        }
        plane.check_refused(path + "x", 422, "value_out_of_range", name);
        continue;
      }
      for (const std::string bound : {"minimum", "default"}) {
        CHECK(plane.ask(path + parameter[bound].dump())["reachable"] == true);
      }
      plane.check_refused(path + "x", 400, "bad_syntax", name);
      plane.check_refused(path + "0", 422, "value_out_of_range", name);
      const double above = 2 * parameter["maximum"].get<double>();
      plane.check_refused(
          path + json(parameter["type"] == "integer" ? json(static_cast<int>(above)) : json(above))
                     .dump(),
          422, "value_out_of_range", name);
      const std::string field = "/distance?" + query + parameter["default"].dump();
      if (parameter["for"] == "paths") {
        plane.check_refused(field, 400, "unknown_parameter", name);
      } else {
        CHECK(plane.ask(field)["reached"] == 120);
      }
    }
  }
}

TEST_CASE("AGraphOfTooManyPointsIsRefusedByEveryQuery") {
  PlaneService plane;
  // 327,360 edges: 64 points on each are more than 20 million nodes, 3 are not.
  const std::string base = plane.add(shapes::plane(331, 331));
  for (const std::string query :
       {"/distance?from=v:0&at=v:5", "/distance?from=v:0", "/table?from=v:0",
        "/isolines?from=v:0&count=1", "/samples?count=1", "/path?from=v:0&to=v:1"}) {
    CAPTURE(query);
    const HttpResponse response =
        plane.service.get(base + query + "&method=steiner&points_per_edge=64");
    check_problem(response, 413, "too_large", "points_per_edge");
    CHECK(body_of(response)["limit"] == 20'000'000);
    CHECK(body_of(response)["actual"] == 331 * 331 + 64 * (2 * 331 * 330 + 330 * 330));
  }
  CHECK(body_of(
            plane.service.get(base + "/distance?from=v:0&at=v:5&method=steiner"))["distances"][0] ==
        doctest::Approx(5));
}
