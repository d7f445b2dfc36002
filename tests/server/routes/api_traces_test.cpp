// Straightest geodesics.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("TraceOnAPlaneGoesStraightAsFarAsAsked") {
  PlaneService plane;
  const json reply = plane.ask("/trace?from=p:1.25,2.5,0&direction=3,4,0&length=5.5");
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["end"] == "length");
  CHECK(reply["length"] == doctest::Approx(5.5));
  CHECK(length_of(reply["points"]) == doctest::Approx(5.5));
  CHECK(reply["from"]["xyz"] == json::parse("[1.25,2.5,0]"));
  CHECK(reply["to"]["xyz"][0] == doctest::Approx(1.25 + 3.3));
  CHECK(reply["to"]["xyz"][1] == doctest::Approx(2.5 + 4.4));
  CHECK(reply["points"].back()["xyz"] == reply["to"]["xyz"]);
  CHECK(reply["direction_at_end"][0] == doctest::Approx(0.6));
  CHECK(reply["direction_at_end"][1] == doctest::Approx(0.8));
  for (const json& point : reply["points"]) CHECK(point["face"].is_number());
}

TEST_CASE("TraceProjectsItsDirection") {
  PlaneService plane;
  const json reply = plane.ask("/trace?from=v:13&direction=1,0,7&length=4");
  CHECK(reply["to"]["xyz"][0] == doctest::Approx(5));
  CHECK(reply["to"]["xyz"][1] == doctest::Approx(1));
}

TEST_CASE("TraceStopsWhereTheSurfaceDoes") {
  PlaneService plane;
  const json wall = plane.ask("/trace?from=p:1.25,2.5,0&direction=1,0,0&length=100");
  CHECK(wall["end"] == "boundary");
  CHECK(wall["length"] == doctest::Approx(9.75));
  CHECK(wall["to"]["xyz"][0] == doctest::Approx(11));
  const std::string book = plane.add(fixtures::book_of_three_pages());
  const json spine =
      body_of(plane.service.get(book + "/trace?from=p:1.25,0.6,0&direction=-1,0,0&length=100"));
  CHECK(spine["end"] == "non_manifold");
  CHECK(spine["length"] == doctest::Approx(1.25));
  CHECK(std::abs(spine["to"]["xyz"][0].get<double>()) < 1e-12);
}

TEST_CASE("TraceByAngleTurnsInTheFaceThatTheReplyNames") {
  PlaneService plane;
  const std::string query = "/trace?from=f:100,0.3,0.3&length=1.5&angle=";
  const json ahead = plane.ask(query + "0");
  const json left = plane.ask(query + "1.5707963267948966");
  const auto vector = [](const json& reply, int k) {
    return reply["to"]["xyz"][k].get<double>() - reply["from"]["xyz"][k].get<double>();
  };
  // From the first corner towards the second …
  const json corner0 = plane.ask("/nearest?point=f:100,1,0")["points"][0]["xyz"];
  const json corner1 = plane.ask("/nearest?point=f:100,0,1")["points"][0]["xyz"];
  for (int k = 0; k < 3; ++k) {
    const double side = corner1[k].get<double>() - corner0[k].get<double>();
    CHECK(vector(ahead, k) == doctest::Approx(1.5 * side));
  }
  // … and a quarter turn from there.
  CHECK(vector(ahead, 0) * vector(left, 0) + vector(ahead, 1) * vector(left, 1) ==
        doctest::Approx(0));
  CHECK(left["length"] == doctest::Approx(1.5));
  // At a vertex, all the way round is where it began.
  const json once = plane.ask("/trace?from=v:53&length=2.25&angle=0.5");
  const json again = plane.ask("/trace?from=v:53&length=2.25&angle=6.783185307179586");
  for (int k = 0; k < 3; ++k) CHECK(vector(once, k) == doctest::Approx(vector(again, k)));
}

TEST_CASE("TraceOfNoLengthIsItsStart") {
  PlaneService plane;
  const json reply = plane.ask("/trace?from=v:13&direction=1,0,0&length=0");
  CHECK(reply["points"].size() == 1);
  CHECK(reply["length"] == 0);
  CHECK(reply["to"]["xyz"] == reply["from"]["xyz"]);
}

TEST_CASE("OnASphereTheTraceIsHardlyLongerThanTheShortestPathToItsEnd") {
  PlaneService plane;
  const std::string base = plane.add(shapes::icosphere(4));
  const json reply = body_of(
      plane.service.get(base + "/trace?from=f:123,0.3,0.4&direction=0.3,0.5,-0.2&length=1.2"));
  const json& to = reply["to"];
  const std::string end =
      "f:" + to["face"].dump() + "," + to["bary"][0].dump() + "," + to["bary"][1].dump();
  const json path =
      body_of(plane.service.get(base + "/path?from=f:123,0.3,0.4&refine=shortest&to=" + end));
  CHECK(reply["length"] == doctest::Approx(1.2).epsilon(1e-12));
  CHECK(path["length"] <= 1.2);
  CHECK(path["length"] > 1.2 * (1 - 1e-4));
}

TEST_CASE("TraceByGetAndPostAndAsAnArray") {
  PlaneService plane;
  const std::string query = "/trace?from=v:13&direction=1,0.5,0&length=4.5";
  plane.check_same(query, R"({"from":"v:13","direction":[1,0.5,0],"length":4.5})");
  plane.check_same(query, R"({"from":{"vertex":13},"direction":"1,0.5,0","length":4.5})");
  plane.check_same("/trace?from=v:13&angle=-0.25&length=2&precision=8",
                   R"({"from":"v:13","angle":-0.25,"length":2,"precision":8})");
  const json reply = plane.ask(query);
  const HttpResponse f64 = plane.service.get(plane.base + query + "&format=f64");
  CHECK(header_of(f64, "Geo-Shape") == std::to_string(reply["points"].size()) + ",3");
  CHECK(std::stod(header_of(f64, "Geo-Length")) == reply["length"].get<double>());
  CHECK(numbers_of<double>(f64).back() == reply["to"]["xyz"][2].get<double>());
}

TEST_CASE("TracesThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/trace?direction=1,0,0&length=1", 400, "bad_syntax", "from");
  plane.check_refused("/trace?from=v:0&length=1", 400, "bad_syntax", "direction");
  plane.check_refused("/trace?from=v:0&direction=1,0,0", 400, "bad_syntax", "length");
  plane.check_refused("/trace?from=v:0&direction=1,0,0&angle=1&length=1", 400, "bad_syntax",
                      "angle");
  for (const std::string direction : {"1,0", "1,0,0,0", "x,0,0", "north", ""}) {
    plane.check_refused("/trace?from=v:0&length=1&direction=" + direction, 400, "bad_syntax",
                        "direction");
  }
  plane.check_refused("/trace?from=v:0&angle=left&length=1", 400, "bad_syntax", "angle");
  plane.check_refused("/trace?from=v:0&direction=0,0,0&length=1", 422, "value_out_of_range",
                      "direction");
  plane.check_refused("/trace?from=v:13&direction=0,0,1&length=1", 422, "value_out_of_range",
                      "direction");
  plane.check_refused("/trace?from=v:13&direction=1,0,0&length=-1", 422, "value_out_of_range",
                      "length");
  plane.check_refused("/trace?from=v:0&angle=-0.1&length=1", 422, "value_out_of_range", "angle");
  plane.check_refused("/trace?from=v:0&angle=3&length=1", 422, "value_out_of_range", "angle");
  plane.check_refused("/trace?from=v:120&angle=0&length=1", 422, "index_out_of_range", "from");
  plane.check_refused("/trace?from=v:0&angle=0&length=1&method=exact", 400, "unknown_parameter",
                      "method");
  plane.check_refused("/trace?from=v:0&angle=0&length=1&format=csv", 406, "not_acceptable",
                      "format");
  for (const std::string direction : {"[1,0]", "[1,0,\"0\"]", "[1,0,null]", "1", "{}"}) {
    check_problem(plane.service.ask("POST", plane.base + "/trace",
                                    R"({"from":"v:0","length":1,"direction":)" + direction + "}"),
                  400, "bad_syntax", "direction");
  }
  TriangleSoup soup = shapes::plane(3, 3);
  soup.positions.push_back({9, 9, 9});
  check_problem(plane.service.get(plane.add(soup) + "/trace?from=v:9&angle=0&length=1"), 422,
                "value_out_of_range", "from");
}

TEST_CASE("ATraceThatCrossesTooManyFacesIsRefused") {
  PlaneService plane;
  const std::string base = plane.add(shapes::icosphere(1));
  check_problem(plane.service.get(base + "/trace?from=f:3,0.3,0.4&direction=1,0.3,0.2&length=1e9"),
                413, "too_large", "length");
}
