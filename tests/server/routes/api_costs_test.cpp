// Cheap ways instead of short ones: weights of faces, and slopes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/gltf/weights.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/proto/gltf_file/draco_fixture.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// Hills whose up is +Y, as in glTF, and whose edges rise by a quarter at most: who climbs more
// steeply zigzags, and the finer the better.
TriangleSoup hills(std::uint32_t side, std::uint32_t number) {
  TriangleSoup soup = shapes::terrain(side, 5, number);
  double steepest = 0;
  for (const Triangle& t : soup.faces) {
    for (int c = 0; c < 3; ++c) {
      const Vec3 along = soup.positions[t[(c + 1) % 3]] - soup.positions[t[c]];
      steepest = std::max(steepest, std::abs(along.z) / std::hypot(along.x, along.y));
    }
  }
  for (Vec3& p : soup.positions) p = {p.x, 0.25 / steepest * p.z, -p.y};
  return soup;
}

double seconds(Vec3 from, Vec3 to) {
  const Vec3 along = to - from;
  const double slope = along.y / std::hypot(along.x, along.z);
  return norm(along) / (6 / 3.6 * std::exp(-3.5 * std::abs(slope + 0.05)));
}

Vec3 xyz_of(const json& point) { return {point["xyz"][0], point["xyz"][1], point["xyz"][2]}; }

}  // namespace

// What `format=annotated` writes is read again: distances from elsewhere, as weights.
TEST_CASE("WeightsAreReadFromAnAttributeOfTheFile") {
  PlaneService plane;
  const json source = {{"from", {{{"vertex", 7}, {"offset", 50}}}}};
  json annotated_with = source;
  annotated_with.update({{"format", "annotated"}, {"attribute", "_MUD"}});
  const HttpResponse file =
      plane.service.ask("POST", plane.base + "/distance", annotated_with.dump());
  REQUIRE(file.status == 200);
  const HttpResponse upload = plane.service.ask("POST", "/v1/meshes", *file.body);
  REQUIRE(upload.status == 201);
  const std::string base = "/v1/meshes/" + body_of(upload)["id"].get<std::string>();
  // By the corners of each face, as the client has them.
  const json field =
      body_of(plane.service.ask("POST", plane.base + "/distance", source.dump()))["distances"];
  const TriangleSoup soup = shapes::plane(12, 10);
  json weights = json::array();
  for (const Triangle& face : soup.faces) {
    double sum = 0;
    for (const std::uint32_t v : face) sum += static_cast<float>(field[v].get<double>());
    weights.push_back(sum / 3);
  }
  const auto both = [&](const std::string& query, json asked) {
    asked["face_weights"] = weights;
    const HttpResponse sent = plane.service.ask("POST", base + query, asked.dump());
    REQUIRE(sent.status == 200);
    asked.erase("face_weights");
    asked["weight_attribute"] = "_MUD";
    const HttpResponse read = plane.service.ask("POST", base + query, asked.dump());
    REQUIRE(read.status == 200);
    CHECK(*sent.body == *read.body);
  };
  both("/distance", {{"from", "v:0"}});
  both("/path", {{"from", "v:0"},
                 {"to", "v:119"},
                 {"weights", "2*faces:7"},
                 {"up", {0, 0, 1}},
                 {"slope", "-1:2,1:3"}});
  both("/isolines", {{"from", "v:0"}, {"levels", {60}}});
  both("/table", {{"from", {"v:0", "v:5"}}, {"to", {"v:9"}}});
  CHECK(body_of(plane.service.get(
            base + "/distance?from=v:0&at=v:9&weight_attribute=_MUD"))["unit"] == "length");
  const auto refused = [&](const std::string& where, const std::string& query, int status,
                           const std::string& code) {
    CAPTURE(query);
    const HttpResponse reply = plane.service.get(where + query);
    check_problem(reply, status, code, "weight_attribute");
    return body_of(reply)["detail"].get<std::string>();
  };
  const std::string none =
      refused(base, "/distance?from=v:0&weight_attribute=_SNOW", 422, "value_out_of_range");
  CHECK(none.find("_MUD") != std::string::npos);
  CHECK(none.find("POSITION") != std::string::npos);
  refused(base, "/distance?from=v:0&weight_attribute=MUD", 422, "value_out_of_range");
  refused(base, "/distance?from=v:0&weight_attribute=_MUD&face_weights=1", 400, "bad_syntax");
  plane.check_refused("/measure?from=v:0&radii=1&weight_attribute=_MUD", 400, "unknown_parameter",
                      "weight_attribute");
  // They are kept with what is prepared of the mesh, and go with it.
  const auto kept = [&] {
    std::vector<std::string> keys;
    const json cached = body_of(plane.service.get("/debug/cache"));
    for (const json& entry : cached["adjacency"]) {
      const auto key = entry["key"].get<std::string>();
      if (key.find("/weights/") != std::string::npos) keys.push_back(key);
    }
    return keys;
  };
  CHECK(kept() ==
        std::vector<std::string>{base.substr(std::string("/v1/meshes/").size()) + "/weights/_MUD"});
  // A vertex at no distance, and an attribute of three numbers.
  const auto again = [&](const std::string& query) {
    const HttpResponse annotated = plane.service.get(plane.base + query);
    REQUIRE(annotated.status == 200);
    return "/v1/meshes/" + body_of(plane.service.ask("POST", "/v1/meshes", *annotated.body))["id"]
                               .get<std::string>();
  };
  refused(again("/distance?from=v:0&format=annotated&attribute=_ZERO"),
          "/path?from=v:0&to=v:5&weight_attribute=_ZERO", 422, "value_out_of_range");
  refused(again("/logmap?from=v:0&format=annotated&attribute=_THREE"),
          "/path?from=v:0&to=v:5&weight_attribute=_THREE", 422, "value_out_of_range");
  CHECK(plane.service.ask("DELETE", base).status == 204);
  CHECK(kept().empty());
}

// Of these there are as many as the mesh has faces.
TEST_CASE("FieldsOfWeightsThatTheFileHasAreKnownByMeshAndAttribute") {
  const auto key = [](const std::string& mesh, const std::string& attribute, double weight) {
    proto::Costs costs;
    costs.weight_attribute = attribute;
    costs.face_weights = {weight, 2};
    return AskedSurface(mesh, {}, std::move(costs)).field_key();
  };
  CHECK(key("a", "_MUD", 1) == key("a", "_MUD", 3));  // they are not looked at
  CHECK(key("a", "_MUD", 1) != key("a", "_SNOW", 1));
  CHECK(key("a", "_MUD", 1) != key("b", "_MUD", 1));
  CHECK(key("a", "_MUD", 1) != key("a", "", 1));
  CHECK(key("a", "", 1) != key("a", "", 3));
}

TEST_CASE("WeightsAreReadOutOfDracoData") {
  PlaneService plane;
  const TriangleSoup soup = shapes::terrain(8, 3, fixtures::test_seed());
  proto::DracoNumbers numbers;
  for (std::size_t corner = 0; corner < 3 * soup.faces.size(); ++corner) {
    numbers.at_corner.push_back(1 + static_cast<double>(corner * 7 % 11));
  }
  const proto::DracoFixture draco = proto::draco_of(soup, numbers);
  proto::GltfFixture file;
  file.mesh({proto::draco_primitive(file, draco, numbers, "_MUD")});
  file.node({{"mesh", 0}});
  const proto::Bytes glb = file.glb();
  const auto text = [](const proto::Bytes& bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  const std::string base = "/v1/meshes/" + plane.service.upload(text(glb));
  const auto weights = proto::read_face_numbers(glb, {}, {}, "_MUD", proto::FaceNumber::weight);
  REQUIRE(weights);
  const HttpResponse sent = plane.service.ask(
      "POST", base + "/distance", json{{"from", "v:0"}, {"face_weights", weights->by_face}}.dump());
  REQUIRE(sent.status == 200);
  CHECK(*plane.service.get(base + "/distance?from=v:0&weight_attribute=_MUD").body == *sent.body);
  check_problem(plane.service.get(base + "/distance?from=v:0&weight_attribute=_SNOW"), 422,
                "value_out_of_range", "weight_attribute");
  // Without names there is nothing to ask for, by whatever format.
  for (const std::string& nameless :
       {text(draco.bytes), std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")}) {
    const HttpResponse refused = plane.service.get("/v1/meshes/" + plane.service.upload(nameless) +
                                                   "/distance?from=v:0&weight_attribute=_MUD");
    check_problem(refused, 422, "value_out_of_range", "weight_attribute");
    CHECK(body_of(refused)["detail"].get<std::string>().find("face_weights") != std::string::npos);
  }
}

TEST_CASE("LabelsAreReadOutOfDracoData") {
  PlaneService plane;
  const TriangleSoup soup = shapes::terrain(8, 3, fixtures::test_seed());
  proto::DracoNumbers numbers;
  // Whole numbers that floats cannot tell apart.
  constexpr double kFirst = 16'777'216;
  numbers.component_type = 5125;
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    numbers.at_corner.insert(numbers.at_corner.end(), 3, kFirst + static_cast<double>(f / 16));
  }
  const proto::DracoFixture draco = proto::draco_of(soup, numbers);
  proto::GltfFixture file;
  file.mesh({proto::draco_primitive(file, draco, numbers, "_ROOM")});
  file.node({{"mesh", 0}});
  const proto::Bytes glb = file.glb();
  const std::string base =
      "/v1/meshes/" +
      plane.service.upload(std::string(reinterpret_cast<const char*>(glb.data()), glb.size()));
  const auto labels = proto::read_face_numbers(glb, {}, {}, "_ROOM", proto::FaceNumber::label);
  REQUIRE(labels);
  REQUIRE(labels->by_face.size() == soup.faces.size());
  for (std::size_t f = 0; f < labels->by_face.size(); f += 11) {
    json same = json::array();
    for (std::size_t g = 0; g < labels->by_face.size(); ++g) {
      if (labels->by_face[g] == labels->by_face[f]) same.push_back(g);
    }
    CHECK(same.size() <= 16);
    REQUIRE(!same.empty());
    json asked{{"from", "f:" + std::to_string(f) + ",0.3,0.3"}, {"within", {{"faces", same}}}};
    const HttpResponse wanted = plane.service.ask("POST", base + "/distance", asked.dump());
    REQUIRE(wanted.status == 200);
    asked["within"] = "label:_ROOM=" + std::to_string(static_cast<int>(labels->by_face[f]));
    CHECK(*plane.service.ask("POST", base + "/distance", asked.dump()).body == *wanted.body);
  }
}

TEST_CASE("ACheapestPathSaysWhatItCostsAndHowLongItIs") {
  PlaneService plane;
  // Four times as dear in the middle, along the whole of it: no way round.
  const json reply = plane.ask("/path?from=v:0&to=v:119&weights=4*box:4,-1,-1,7,99,1");
  CHECK(reply["method"] == "steiner");
  CHECK(reply["refine"] == "none");
  CHECK(reply["unit"] == "length");
  REQUIRE(reply["segments"].size() + 1 == reply["points"].size());
  double length = 0;
  double cost = 0;
  for (std::size_t i = 0; i < reply["segments"].size(); ++i) {
    const json& segment = reply["segments"][i];
    const Vec3 from = xyz_of(reply["points"][i]);
    const Vec3 to = xyz_of(reply["points"][i + 1]);
    CHECK(segment["length"] == doctest::Approx(distance(from, to)));
    const double middle = (from.x + to.x) / 2;
    const double weight = middle > 4 && middle < 7 ? 4 : 1;
    CHECK(segment["cost"] == doctest::Approx(weight * distance(from, to)));
    length += segment["length"].get<double>();
    cost += segment["cost"].get<double>();
  }
  CHECK(reply["length"] == doctest::Approx(length));
  CHECK(reply["cost"] == doctest::Approx(cost));
  // Snell's law: the least by two heights, looked for on a fine grid.
  double truth = 1e9;
  for (double y = 0; y <= 9; y += 0.01) {
    for (double z = y; z <= 9; z += 0.01) {
      truth = std::min(truth, std::hypot(4, y) + 4 * std::hypot(3, z - y) + std::hypot(4, 9 - z));
    }
  }
  CHECK(cost <= truth * 1.005);
  CHECK(cost >= truth * (1 - 1e-4));
}

TEST_CASE("TimesOnAHillAreThoseOfTheirSegmentsAndDependOnTheDirection") {
  const std::uint32_t number = fixtures::test_seed();
  CAPTURE(number);
  PlaneService plane;
  const TriangleSoup soup = hills(16, number);
  const std::string base = plane.add(soup);
  double back = 0;  // along the same way, the other way
  const auto time = [&](int from, int to) {
    const HttpResponse response = plane.service.get(
        base + "/path?slope=tobler&from=v:" + std::to_string(from) + "&to=v:" + std::to_string(to));
    REQUIRE(response.status == 200);
    const json reply = body_of(response);
    CHECK(reply["unit"] == "seconds");
    double sum = 0;
    for (std::size_t i = 0; i < reply["segments"].size(); ++i) {
      const double each = seconds(xyz_of(reply["points"][i]), xyz_of(reply["points"][i + 1]));
      CHECK(reply["segments"][i]["cost"] == doctest::Approx(each));
      sum += each;
    }
    CHECK(reply["cost"] == doctest::Approx(sum));
    back = 0;
    for (std::size_t i = 0; i < reply["segments"].size(); ++i) {
      back += seconds(xyz_of(reply["points"][i + 1]), xyz_of(reply["points"][i]));
    }
    return reply["cost"].get<double>();
  };
  int up = 0;
  int down = 0;
  for (int v = 0; v < 256; ++v) {
    if (soup.positions[v].y > soup.positions[up].y) up = v;
    if (soup.positions[v].y < soup.positions[down].y) down = v;
  }
  const double climb = time(down, up);
  const double climbed_back = back;
  const double descent = time(up, down);
  CHECK(climb != descent);
  CHECK(descent <= climbed_back * 1.05);
  CHECK(climb <= back * 1.05);
  // A field goes outwards: what it says is at most refined by the path, whose steps are as said.
  const HttpResponse field =
      plane.service.get(base + "/distance?slope=tobler&from=v:" + std::to_string(down));
  REQUIRE(field.status == 200);
  const json all = body_of(field);
  CHECK(all["unit"] == "seconds");
  const double there = all["distances"][up];
  CHECK(climb <= there * (1 + 1e-6));
  CHECK(climb >= there * 0.9);
  // Isochrones, and the same numbers in a table.
  const HttpResponse lines =
      plane.service.get(base + "/isolines?slope=tobler&count=6&from=v:" + std::to_string(down));
  REQUIRE(lines.status == 200);
  CHECK(body_of(lines)["unit"] == "seconds");
  CHECK(body_of(lines)["max"] == all["max"]);
  CHECK(body_of(lines)["isolines"].size() > 1);
  const HttpResponse table =
      plane.service.get(base + "/table?slope=tobler&from=v:" + std::to_string(down) +
                        "&from=v:" + std::to_string(up));
  REQUIRE(table.status == 200);
  CHECK(body_of(table)["unit"] == "seconds");
  CHECK(body_of(table)["distances"][0][1] == all["distances"][up]);
  CHECK(body_of(table)["distances"][1][0] >= descent * (1 - 1e-6));
}

TEST_CASE("OnSteepGroundCostsComeWithAWarning") {
  PlaneService plane;
  TriangleSoup soup = shapes::plane(10, 10);
  const auto warnings = [&](double slope, const std::string& asked) {
    for (Vec3& p : soup.positions) p.z = slope * p.x;
    const HttpResponse response = plane.service.get(plane.add(soup) + asked + "&up=0,0,1");
    REQUIRE(response.status == 200);
    return body_of(response).value("warnings", json::array()).size();
  };
  for (const std::string asked :
       {"/path?from=v:0&to=v:9&slope=tobler", "/distance?from=v:0&slope=tobler",
        "/table?from=v:0&to=v:9&slope=energy", "/isolines?from=v:0&count=2&slope=energy",
        "/path?from=v:0&to=v:9&steepest=0.2"}) {
    CAPTURE(asked);
    CHECK(warnings(0.1, asked) == 0);
    CHECK(warnings(2, asked) == 1);
    CHECK(warnings(2, asked + "&points_per_edge=20") == 0);
  }
  CHECK(warnings(20, "/path?from=v:0&to=v:9&weights=2*faces:0-9&steepest=1e3") == 0);
}

// Paths through two names of one place, with the slope that rounding gives to what is between them.
TEST_CASE("APathThatHasNoLengthSomewhereHasACost") {
  PlaneService plane;
  const std::string id = plane.service.upload(
      "v -0.6859943405700355 -0.17149858514250887 0.04615977181832229\n"
      "v -0.42874646285627216 0.2572478777137633 0.017460716814080145\n"
      "v -0.8574929257125443 0.5144957554275266 0.029815767603516515\n"
      "v -1.371988681140071 -0.34299717028501775 0.013994117542477081\n"
      "v -1.5434872662825796 0.34299717028501775 0.017801830642976312\n"
      "v -2.229481606852615 0.17149858514250882 0.04113750486741198\n"
      "v -1.1147408034263075 0.08574929257125441 0.0219049425729968\n"
      "f 1 2 3\nf 1 3 4\nf 5 6 4\nf 5 4 7\nf 5 7 3\nf 3 7 4\n");
  const HttpResponse response =
      plane.service.get("/v1/meshes/" + id + "/path?from=v:5&to=v:1&slope=tobler&up=0,0,1");
  REQUIRE(response.status == 200);
  const json reply = body_of(response);
  REQUIRE(reply["reachable"] == true);
  CHECK(reply["cost"].get<double>() == doctest::Approx(1.25).epsilon(0.02));
  for (const json& segment : reply["segments"]) CHECK(segment["cost"].is_number());
}

TEST_CASE("EnergyIsInJoulesAKilogram") {
  PlaneService plane;
  const TriangleSoup soup = hills(16, fixtures::test_seed());
  const std::string base = plane.add(soup);
  const TravelCost cost({.rate = TravelCost::Rate::energy});
  const HttpResponse response = plane.service.get(base + "/path?slope=energy&from=v:0&to=v:255");
  REQUIRE(response.status == 200);
  const json reply = body_of(response);
  CHECK(reply["unit"] == "joules_per_kilogram");
  double sum = 0;
  for (std::size_t i = 0; i < reply["segments"].size(); ++i) {
    const double each = cost.of(0, xyz_of(reply["points"][i]), xyz_of(reply["points"][i + 1]));
    CHECK(reply["segments"][i]["cost"] == doctest::Approx(each));
    sum += each;
  }
  CHECK(reply["cost"] == doctest::Approx(sum));
  const HttpResponse other = plane.service.get(base + "/path?slope=tobler&from=v:0&to=v:255");
  REQUIRE(other.status == 200);
  CHECK(body_of(other)["unit"] == "seconds");
}

TEST_CASE("CostsAreTheSameWhateverWasAskedBefore") {
  PlaneService plane;
  const std::string costs = "&weights=3*faces:0-60&weights=0.5*faces:50-90&slope=0:1,1:2&up=1,0,1";
  const std::string inside =
      "/distance?from=f:3,0.2,0.3&from=v:90&labels=1&at=f:100,0.1,0.5&at=v:5";
  const json before = plane.ask(inside + costs);
  const json field = plane.ask("/distance?from=f:3,0.2,0.3&from=v:90&labels=1" + costs);
  const json after = plane.ask(inside + costs);
  CHECK(before == after);
  CHECK(before["distances"][1] == field["distances"][5]);
  CHECK(before["labels"][1] == field["labels"][5]);
  CHECK(before["unit"] == "cost");
  // Other costs are other fields.
  CHECK(plane.ask(inside + "&weights=2*faces:0-60")["distances"] != before["distances"]);
  CHECK(plane.ask("/distance?from=v:0&at=v:119&method=steiner")["distances"][0] ==
        plane.ask("/distance?from=v:0&at=v:119&weights=1*faces:0")["distances"][0]);
  // In a part of the surface.
  const json part =
      plane.ask("/path?from=v:0&to=v:11&forbid=box:4,-1,-1,5,5,1&weights=2*box:0,0,0,99,3,0");
  CHECK(part["reachable"] == true);
  CHECK(part["length"] > 11.5);
  const json none = plane.ask("/path?from=v:0&to=v:11&forbid=box:4,-1,-1,5,99,1&weights=2*faces:0");
  CHECK(none["reachable"] == false);
  CHECK(none["cost"] == nullptr);
  CHECK(none["segments"].empty());
}

TEST_CASE("WeightsByFaceAreThoseOfRegions") {
  PlaneService plane;
  json weights = json::array();
  for (int f = 0; f < 198; ++f) weights.push_back(f < 60 ? 3 : 1);
  const HttpResponse by_face = plane.service.ask(
      "POST", plane.base + "/distance", json{{"from", "v:0"}, {"face_weights", weights}}.dump());
  REQUIRE(by_face.status == 200);
  CHECK(body_of(by_face)["distances"] ==
        plane.ask("/distance?from=v:0&weights=3*faces:0-59")["distances"]);
  plane.check_same(
      "/path?from=v:0&to=v:9&weights=3*faces:0-59&weights=2*sphere:1,2,0,3&slope=-1:2,1:3"
      "&steepest=2&up=0,0,1",
      R"({"from":"v:0","to":"v:9","weights":[{"weight":3,"region":{"faces":[[0,59]]}},)"
      R"({"weight":2,"region":{"sphere":{"center":[1,2,0],"radius":3}}}],)"
      R"("slope":[[-1,2],[1,3]],"steepest":2,"up":[0,0,1]})");
}

TEST_CASE("WhatIsWrongWithCostsIsSaid") {
  PlaneService plane;
  const std::string path = "/path?from=v:0&to=v:9&";
  for (const auto& [asked, status, code, parameter] :
       std::vector<std::tuple<std::string, int, std::string, std::string>>{
           {"weights=3", 400, "bad_syntax", "weights[0]"},
           {"weights=x*faces:0", 400, "bad_syntax", "weights[0]"},
           {"weights=3*ball:0", 400, "bad_syntax", "weights[0]"},
           {"weights=0*faces:0", 422, "value_out_of_range", "weights[0].weight"},
           {"weights=2*faces:0&weights=-1*faces:0", 422, "value_out_of_range", "weights[1].weight"},
           {"weights=1e10*faces:0", 422, "value_out_of_range", "weights[0].weight"},
           {"weights=2*faces:198", 422, "index_out_of_range", "weights[0].faces[0]"},
           {"weights=2*part:7", 422, "index_out_of_range", "weights[0].part"},
           {"face_weights=1&face_weights=2", 422, "value_out_of_range", "face_weights"},
           {"face_weights=0", 422, "value_out_of_range", "face_weights[0]"},
           {"face_weights=x", 400, "bad_syntax", "face_weights[0]"},
           {"slope=naismith", 400, "bad_syntax", "slope"},
           {"slope=1:2:3", 400, "bad_syntax", "slope"},
           {"slope=0:1,0:2", 422, "value_out_of_range", "slope[1]"},
           {"slope=1e10:1", 422, "value_out_of_range", "slope[0]"},
           {"slope=0:0", 422, "value_out_of_range", "slope[0]"},
           {"slope=tobler&slope=tobler", 400, "bad_syntax", "slope"},
           {"slope=tobler&up=0,0,0", 422, "value_out_of_range", "up"},
           {"slope=tobler&up=1", 400, "bad_syntax", "up"},
           {"steepest=0", 422, "value_out_of_range", "steepest"},
           {"up=0,1,0", 400, "unknown_parameter", "up"},
           {"slope=tobler&method=exact", 422, "value_out_of_range", "method"},
           {"slope=tobler&refine=shortest", 422, "value_out_of_range", "refine"},
       }) {
    plane.check_refused(path + asked, status, code, parameter);
  }
  // Elsewhere there is no such parameter.
  plane.check_refused("/samples?count=2&slope=tobler", 400, "unknown_parameter", "slope");
  plane.check_refused("/trace?from=v:0&angle=0&length=1&weights=2*faces:0", 400,
                      "unknown_parameter", "weights");
  const auto too_many = [&](const json& asked, const char* parameter, int limit) {
    const HttpResponse response = plane.service.ask("POST", plane.base + "/distance", asked.dump());
    check_problem(response, 413, "too_large", parameter);
    CHECK(body_of(response)["limit"] == limit);
  };
  check_problem(
      plane.service.ask("POST", plane.base + "/distance", R"({"from":"v:0","face_weights":[]})"),
      400, "bad_syntax", "face_weights");
  too_many({{"from", "v:0"}, {"weights", std::vector<std::string>(1001, "2*faces:0")}}, "weights",
           1000);
  json steps = json::array();
  for (int i = 0; i <= 1000; ++i) steps.push_back({i, 1});
  too_many({{"from", "v:0"}, {"slope", steps}}, "slope", 1000);
  json ranges = json::array();
  for (int i = 0; i <= 100'000; ++i) ranges.push_back(0);
  too_many({{"from", "v:0"}, {"weights", {{{"weight", 2}, {"region", {{"faces", ranges}}}}}}},
           "weights", 100'000);
  for (const char* body :
       {R"({"from":"v:0","weights":[{"weight":2}]})",
        R"({"from":"v:0","weights":[{"weight":"2","region":"faces:0"}]})",
        R"({"from":"v:0","weights":7})", R"({"from":"v:0","slope":[1,2]})",
        R"({"from":"v:0","slope":[[1,"2"]]})", R"({"from":"v:0","slope":7})",
        R"({"from":"v:0","slope":["tobler",[1,2]]})", R"({"from":"v:0","slope":[]})"}) {
    CAPTURE(body);
    CHECK(plane.service.ask("POST", plane.base + "/distance", body).status == 400);
  }
}

TEST_CASE("CostsThatTakeTooMuchMemoryAreRefused") {
  Config config;
  config.query_memory_bytes = 1 << 20;
  PlaneService plane(config);
  const std::string base = plane.add(hills(100, 1));
  const HttpResponse response = plane.service.get(base + "/path?from=v:0&to=v:9999&slope=tobler");
  check_problem(response, 422, "too_much_memory");
}
