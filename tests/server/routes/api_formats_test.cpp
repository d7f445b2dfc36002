// Every format of every query: what a client reads is what the JSON says.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/field/field.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

template <class Number>
Number read(const std::string& bytes, std::size_t offset) {
  REQUIRE(offset + sizeof(Number) <= bytes.size());
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

template <class Number>
std::vector<Number> numbers_at(const std::string& bytes, std::size_t offset, std::size_t size) {
  REQUIRE(offset + size <= bytes.size());
  REQUIRE(offset % 8 == 0);
  std::vector<Number> numbers(size / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data() + offset, size);
  return numbers;
}

struct Frame {
  json about;
  std::string bytes;

  explicit Frame(const HttpResponse& response) : bytes(*response.body) {
    CHECK(response.content_type == "application/vnd.geodesic.frame");
    CHECK(bytes.starts_with("GEOD"));
    CHECK(read<std::uint32_t>(bytes, 4) == 1);
    CHECK(read<std::uint64_t>(bytes, 16) == bytes.size());
    about = json::parse(bytes.substr(24, read<std::uint32_t>(bytes, 8)));
  }
  template <class Number>
  std::vector<Number> array(const std::string& name, const std::string& dtype,
                            const std::vector<int>& shape) {
    for (const json& array : about["arrays"]) {
      if (array["name"] != name) continue;
      CHECK(array["dtype"] == dtype);
      CHECK(array["shape"].get<std::vector<int>>() == shape);
      return numbers_at<Number>(bytes, array["offset"], array["nbytes"]);
    }
    FAIL("no such array");
    return {};
  }
};

// Two planes apart: the second is out of reach.
TriangleSoup two_planes() {
  TriangleSoup soup = shapes::plane(4, 3);
  const TriangleSoup other = shapes::plane(3, 3);
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const Vec3 p : other.positions) soup.positions.push_back(p + Vec3{0, 0, 5});
  for (const auto& t : other.faces) {
    soup.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return soup;
}

}  // namespace

TEST_CASE("QuantisedFieldsKeepTheGreatestAndTheUnreached") {
  PlaneService plane;
  const std::string base = plane.add(two_planes());
  const json reply = body_of(plane.service.get(base + "/distance?from=v:0&method=wavefront"));
  const HttpResponse u16 =
      plane.service.get(base + "/distance?from=v:0&method=wavefront&format=u16");
  CHECK(header_of(u16, "Geo-Dtype") == "<u2");
  CHECK(header_of(u16, "Geo-Shape") == "21");
  const double max = std::stod(header_of(u16, "Geo-Max"));
  CHECK(max == reply["max"].get<double>());
  const auto steps = numbers_of<std::uint16_t>(u16);
  REQUIRE(steps.size() == 21);
  for (std::size_t i = 0; i < 21; ++i) {
    if (reply["distances"][i].is_null()) {
      CHECK(steps[i] == 65535);
    } else {
      CHECK(std::abs(steps[i] * max / 65534 - reply["distances"][i].get<double>()) <= max / 65534);
    }
  }
  CHECK(steps[11] == 65534);  // the far corner
}

TEST_CASE("NumPyFilesHaveTheirHeaderAndThenTheArray") {
  PlaneService plane;
  const HttpResponse npy =
      plane.service.ask("GET", plane.base + "/table?from=v:0&from=v:9&to=v:1&to=v:2&to=v:3", {},
                        {{"Accept", "application/x-npy"}});
  CHECK(npy.content_type == "application/x-npy");
  const std::string& bytes = *npy.body;
  CHECK(bytes.starts_with("\x93NUMPY\x01"));
  const std::size_t header = 10 + read<std::uint16_t>(bytes, 8);
  CHECK(bytes.substr(10, header - 10).find("'shape': (2,3,)") != std::string::npos);
  const json reply = plane.ask("/table?from=v:0&from=v:9&to=v:1&to=v:2&to=v:3");
  const auto values = numbers_at<double>(bytes, header, bytes.size() - header);
  REQUIRE(values.size() == 6);
  for (int i = 0; i < 6; ++i) CHECK(values[i] == reply["distances"][i / 3][i % 3].get<double>());
}

TEST_CASE("FramesHoldTheArraysAndAllTheRest") {
  PlaneService plane;
  const std::string query = "/distance?from=v:0&from=v:119&labels=1&method=wavefront";
  Frame field(plane.service.get(plane.base + query + "&format=frame"));
  json reply = plane.ask(query);
  CHECK(field.array<double>("distances", "<f8", {120}) ==
        reply["distances"].get<std::vector<double>>());
  CHECK(field.array<std::uint32_t>("labels", "<u4", {120}) ==
        reply["labels"].get<std::vector<std::uint32_t>>());
  for (const char* key : {"mesh", "method", "from", "reached", "max", "farthest"}) {
    CHECK(field.about[key] == reply[key]);
  }

  reply = plane.ask("/path?from=v:0&to=v:67");
  const int count = static_cast<int>(reply["points"].size());
  Frame path(plane.service.get(plane.base + "/path?from=v:0&to=v:67&format=frame"));
  const auto xyz = path.array<double>("points", "<f8", {count, 3});
  const auto face = path.array<std::uint32_t>("faces", "<u4", {count});
  const auto bary = path.array<double>("bary", "<f8", {count, 3});
  for (int i = 0; i < count; ++i) {
    CHECK(face[i] == reply["points"][i]["face"]);
    for (int k = 0; k < 3; ++k) {
      CHECK(xyz[3 * i + k] == reply["points"][i]["xyz"][k]);
      CHECK(bary[3 * i + k] == reply["points"][i]["bary"][k]);
    }
  }
  CHECK(path.about["length"] == reply["length"]);
  CHECK_FALSE(path.about.contains("points"));

  Frame table(plane.service.get(plane.base + "/table?from=v:0&from=v:9&format=frame"));
  CHECK(table.array<double>("distances", "<f8", {2, 2})[1] == doctest::Approx(9));
  CHECK(table.about["rows"].size() == 2);
}

TEST_CASE("AGlbOfAFieldIsTheMeshItself") {
  PlaneService plane;
  const std::string base = plane.add(two_planes());
  const HttpResponse glb = plane.service.get(base + "/distance?from=v:0&format=glb");
  CHECK(glb.content_type == "model/gltf-binary");
  CHECK(std::stod(header_of(glb, "Geo-Max")) == doctest::Approx(std::hypot(3, 2)));
  // Uploaded again, it has the same vertices and the same distances.
  const std::string again = "/v1/meshes/" + plane.service.upload(*glb.body);
  CHECK(body_of(plane.service.get(again + "/distance?from=v:0"))["distances"] ==
        body_of(plane.service.get(base + "/distance?from=v:0"))["distances"]);
}

TEST_CASE("LinesComeAsLineStrips") {
  PlaneService plane;
  for (const char* query : {"/path?from=v:0&to=v:67", "/trace?from=v:0&direction=1,1,0&length=3",
                            "/isolines?from=v:0&step=2"}) {
    CAPTURE(query);
    const json reply = plane.ask(query);
    const HttpResponse glb = plane.service.get(plane.base + query + "&format=glb");
    REQUIRE(glb.content_type == "model/gltf-binary");
    const std::string text = glb.body->substr(20, read<std::uint32_t>(*glb.body, 12));
    const json document = json::parse(text);
    const bool isolines = reply.contains("isolines");
    REQUIRE(document["meshes"].size() == (isolines ? reply["isolines"].size() : 1));
    for (std::size_t i = 0; i < document["meshes"].size(); ++i) {
      const json& primitive = document["meshes"][i]["primitives"][0];
      CHECK(primitive["mode"] == 3);
      const json& points = isolines ? reply["isolines"][i]["points"] : reply["points"];
      CHECK(document["accessors"][primitive["attributes"]["POSITION"].get<int>()]["count"] ==
            points.size());
    }
  }
}

TEST_CASE("PicturesAreOfTheSizeAskedFor") {
  PlaneService plane;
  for (const char* query : {"/distance?from=v:0&colormap=turbo&stripes=7", "/path?from=v:0&to=v:67",
                            "/trace?from=v:0&direction=1,1,0&length=3&view=top"}) {
    CAPTURE(query);
    const HttpResponse png =
        plane.service.get(plane.base + query + std::string("&format=png&width=160&height=90"));
    REQUIRE(png.status == 200);
    CHECK(png.content_type == "image/png");
    CHECK(png.body->starts_with("\x89PNG\r\n"));
    CHECK(png.body->substr(16, 8) == std::string("\0\0\0\xa0\0\0\0\x5a", 8));
  }
  // A picture element asks for images, and for anything only if it must.
  const HttpResponse embedded =
      plane.service.ask("GET", plane.base + "/distance?from=v:0", {},
                        {{"Accept", "image/avif,image/webp,image/*,*/*;q=0.8"}});
  CHECK(embedded.content_type == "image/png");
  const HttpResponse browsed =
      plane.service.ask("GET", plane.base + "/distance?from=v:0", {},
                        {{"Accept", "text/html,application/xml;q=0.9,image/webp,*/*;q=0.8"}});
  CHECK(browsed.content_type == "application/json");
}

TEST_CASE("FormatsAreRefusedWhereTheyMakeNoSense") {
  PlaneService plane;
  plane.check_refused("/distance?from=v:0&at=v:1&format=png", 406, "not_acceptable", "format");
  plane.check_refused("/distance?from=v:0&labels=1&format=f32", 406, "not_acceptable", "format");
  plane.check_refused("/path?from=v:0&to=v:1&format=u16", 406, "not_acceptable", "format");
  plane.check_refused("/samples?count=2&format=npy", 406, "not_acceptable", "format");
  plane.check_refused("/isolines?from=v:0&count=2&format=png", 406, "not_acceptable", "format");
  plane.check_refused("/distance?from=v:0&format=png&width=20", 422, "value_out_of_range", "width");
  plane.check_refused("/distance?from=v:0&format=png&height=9000", 422, "value_out_of_range",
                      "height");
  plane.check_refused("/distance?from=v:0&format=png&stripes=900", 422, "value_out_of_range",
                      "stripes");
  plane.check_refused("/distance?from=v:0&format=png&view=inside", 422, "value_out_of_range",
                      "view");
  plane.check_refused("/distance?from=v:0&format=glb&colormap=jet", 422, "value_out_of_range",
                      "colormap");
  plane.check_refused("/distance?from=v:0&format=f32&width=100", 400, "unknown_parameter", "width");
  plane.check_refused("/distance?from=v:0&format=glb&view=top", 400, "unknown_parameter", "view");
  const HttpResponse none = plane.service.ask("GET", plane.base + "/distance?from=v:0", {},
                                              {{"Accept", "text/html, application/*;q=0"}});
  check_problem(none, 406, "not_acceptable", "Accept");
}
