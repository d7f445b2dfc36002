// Tables, and labels: the distances between many points at once.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("TableOfAPlaneIsPythagoras") {
  PlaneService plane;
  const json reply =
      plane.ask("/table?from=v:0&from=v:11&from=p:3.25,4.5,1&to=v:119&to=v:0&to=p:8.5,1.25,0");
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "auto");
  REQUIRE(reply["rows"].size() == 3);
  REQUIRE(reply["columns"].size() == 3);
  CHECK(reply["rows"][1]["vertex"] == 11);
  CHECK(reply["rows"][2]["snap_distance"] == 1);
  CHECK(reply["columns"][0]["vertex"] == 119);
  const std::vector<std::pair<double, double>> from{{0, 0}, {11, 0}, {3.25, 4.5}};
  const std::vector<std::pair<double, double>> to{{11, 9}, {0, 0}, {8.5, 1.25}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      CHECK(reply["distances"][i][j] == doctest::Approx(std::hypot(from[i].first - to[j].first,
                                                                   from[i].second - to[j].second)));
    }
  }
}

TEST_CASE("TableWithoutColumnsIsSquareWithAZeroDiagonal") {
  PlaneService plane;
  const json reply = plane.ask("/table?from=v:5&from=f:40,0.25,0.25&from=v:77");
  CHECK(reply["columns"] == reply["rows"]);
  for (int i = 0; i < 3; ++i) {
    CHECK(reply["distances"][i][i] == 0);
    for (int j = 0; j < i; ++j) {
      CHECK(reply["distances"][i][j].get<double>() ==
            doctest::Approx(reply["distances"][j][i].get<double>()));
    }
  }
}

TEST_CASE("TableDistanceAndPathAgreeByEveryMethod") {
  PlaneService plane;
  const std::string base = plane.add(shapes::icosphere(3));
  const json methods = body_of(plane.service.get("/v1/methods"))["methods"];
  REQUIRE(methods.size() >= 3);
  for (const json& method : methods) {
    const std::string by = "&method=" + method["name"].get<std::string>();
    CAPTURE(by);
    const std::vector<std::string> from{"v:1", "f:300,0.2,0.5"};
    const std::vector<std::string> to{"v:7", "v:300", "f:811,0.25,0.5"};
    std::string query = "/table?from=" + from[0] + "&from=" + from[1];
    for (const std::string& point : to) query += "&to=" + point;
    const json table = body_of(plane.service.get(base + query + by))["distances"];
    for (std::size_t i = 0; i < from.size(); ++i) {
      for (std::size_t j = 0; j < to.size(); ++j) {
        const std::string ends = "?from=" + from[i] + "&";
        const double entry = table[i][j];
        const double at = body_of(
            plane.service.get(base + "/distance" + ends + "at=" + to[j] + by))["distances"][0];
        const double path =
            body_of(plane.service.get(base + "/path" + ends + "to=" + to[j] + by))["length"];
        CHECK(entry == at);
        const double slack = method["exact"] ? 1e-9 : 0.15;
        CHECK(path == doctest::Approx(entry).epsilon(slack));
        // And once more, now that the path has left a whole field in the cache.
        const json again = body_of(plane.service.get(base + query + by))["distances"];
        CHECK(again[i][j].get<double>() == doctest::Approx(entry).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("TableAsABareArray") {
  PlaneService plane;
  const std::string query = "/table?from=v:0&from=v:50&to=v:1&to=v:2&to=v:119&method=wavefront";
  const json reply = plane.ask(query);
  const HttpResponse f64 = plane.service.get(plane.base + query + "&format=f64");
  CHECK(f64.content_type == "application/octet-stream");
  CHECK(header_of(f64, "Geo-Dtype") == "<f8");
  CHECK(header_of(f64, "Geo-Shape") == "2,3");
  const auto numbers = numbers_of<double>(f64);
  REQUIRE(numbers.size() == 6);
  for (int i = 0; i < 6; ++i) CHECK(numbers[i] == reply["distances"][i / 3][i % 3]);
  const HttpResponse f32 =
      plane.service.ask("GET", plane.base + query, {}, {{"Accept", "application/octet-stream"}});
  CHECK(header_of(f32, "Geo-Dtype") == "<f4");
  CHECK(numbers_of<float>(f32)[5] == reply["distances"][1][2].get<float>());
}

TEST_CASE("TableAcrossComponentsAndBeyondMaxIsNull") {
  PlaneService plane;
  const std::string base = plane.add(fixtures::two_components());
  const json reply = body_of(plane.service.get(base + "/table?from=v:0&from=v:30&to=v:24&to=v:49"));
  CHECK(reply["distances"][0][0] == doctest::Approx(std::hypot(4, 4)));
  CHECK(reply["distances"][0][1].is_null());
  CHECK(reply["distances"][1][0].is_null());
  CHECK(reply["distances"][1][1].is_number());
  const auto binary =
      numbers_of<double>(plane.service.get(base + "/table?from=v:0&to=v:49&format=f64"));
  CHECK(std::isinf(binary.at(0)));
  const json bounded = plane.ask("/table?from=v:0&to=v:3&to=v:4&to=f:6,0.5,0.5&max=3.25");
  CHECK(bounded["distances"][0][0] == doctest::Approx(3));
  CHECK(bounded["distances"][0][1].is_null());
}

TEST_CASE("TableUsesFieldsThatAreThere") {
  PlaneService plane;
  // To another target each time, or the whole reply would be there.
  const std::string query = plane.base + "/table?from=v:0&from=v:9&to=v:";
  CHECK(header_of(plane.service.get(query + "100"), "Geo-Cache") == "miss");
  plane.ask("/distance?from=v:0");
  CHECK(header_of(plane.service.get(query + "101"), "Geo-Cache") == "miss");
  plane.ask("/distance?from=v:9");
  CHECK(header_of(plane.service.get(query + "102"), "Geo-Cache") == "hit");
  // And if it is: nothing had to be computed.
  CHECK(header_of(plane.service.get(query + "100"), "Geo-Cache") == "hit");
}

TEST_CASE("TableByGetAndPost") {
  PlaneService plane;
  plane.check_same("/table?from=v:3&from=v:100&to=p:2,3,1&max=4",
                   R"({"from":[{"vertex":3},"v:100"],"to":{"xyz":[2,3,1]},"max":4})");
  plane.check_same("/table?from=v:3&from=v:100&precision=5",
                   R"({"from":["v:3","v:100"],"to":[],"precision":5})");
}

TEST_CASE("TablesThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/table", 400, "bad_syntax", "from");
  plane.check_refused("/table?from=v:0&to=x", 400, "bad_syntax", "to[0]");
  plane.check_refused("/table?from=v:0&to=v:1&to=v:120", 422, "index_out_of_range", "to[1]");
  plane.check_refused("/table?from=v:0&at=v:1", 400, "unknown_parameter", "at");
  plane.check_refused("/table?from=v:0&max=-1", 422, "value_out_of_range", "max");
  plane.check_refused("/table?from=v:0&format=csv", 406, "not_acceptable", "format");
  plane.check_refused("/table?from=v:0&method=magic", 422, "method_unknown", "method");
  const auto refused = [&](const json& body, int status, std::string_view code,
                           std::string_view parameter) {
    const HttpResponse response = plane.service.ask("POST", plane.base + "/table", body.dump());
    check_problem(response, status, code, parameter);
    return body_of(response);
  };
  refused({{"from", {{{"vertex", 0}, {"offset", 1}}}}}, 422, "value_out_of_range",
          "from[0].offset");
  refused({{"from", "v:0"}, {"to", {{{"vertex", 0}, {"offset", 1}}}}}, 422, "value_out_of_range",
          "to[0].offset");
  const json many(1001, "v:1");
  CHECK(refused({{"from", many}}, 413, "too_large", "from")["limit"] == 1000);
  const json rows(1000, "v:1");
  const json entries = refused({{"from", rows}, {"to", many}}, 413, "too_large", "to");
  CHECK(entries["limit"] == 1'000'000);
  CHECK(entries["actual"] == 1'001'000);
}

TEST_CASE("LabelsSayWhichSourceIsNearest") {
  PlaneService plane;
  const json reply = plane.ask("/distance?from=v:0&from=v:11&labels=1");
  REQUIRE(reply["labels"].size() == 120);
  for (int i = 0; i < 120; ++i) CHECK(reply["labels"][i] == (i % 12 < 6 ? 0 : 1));
  // Distances are what they are without labels.
  CHECK(reply["distances"] == plane.ask("/distance?from=v:0&from=v:11")["distances"]);
  CHECK_FALSE(plane.ask("/distance?from=v:0&labels=0").contains("labels"));
}

TEST_CASE("LabelsOfPointsAndOfASingleSource") {
  PlaneService plane;
  const json some =
      plane.ask("/distance?from=v:0&from=v:11&labels=1&at=v:110&at=p:2.25,3.5,0&at=p:9.5,1.25,0");
  CHECK(some["labels"] == json::parse("[0,0,1]"));  // (2, 9) is nearer to (0, 0)
  const json single = plane.ask("/distance?from=v:0&labels=1&max=3.5");
  CHECK(single["labels"][3] == 0);
  CHECK(single["distances"][4].is_null());
  CHECK(single["labels"][4].is_null());
  const std::string base = plane.add(fixtures::two_components());
  const json two = body_of(plane.service.get(base + "/distance?from=v:3&from=v:7&labels=true"));
  CHECK(two["labels"][3] == 0);
  CHECK(two["labels"][7] == 1);
  for (int i = 25; i < 50; ++i) CHECK(two["labels"][i].is_null());
}

TEST_CASE("LabelsByGetAndPostAndInJsonOnly") {
  PlaneService plane;
  plane.check_same("/distance?from=v:3&from=v:100&labels=1",
                   R"({"from":["v:3","v:100"],"labels":true})");
  plane.check_same("/distance?from=v:3&labels=1", R"({"from":"v:3","labels":1})");
  plane.check_refused("/distance?from=v:0&labels=1&format=f32", 406, "not_acceptable", "format");
  check_problem(plane.service.ask("GET", plane.base + "/distance?from=v:0&labels=1", {},
                                  {{"Accept", "application/octet-stream"}}),
                406, "not_acceptable", "Accept");
  plane.check_refused("/distance?from=v:0&labels=all", 400, "bad_syntax", "labels");
  plane.check_refused("/table?from=v:0&labels=1", 400, "unknown_parameter", "labels");
}
