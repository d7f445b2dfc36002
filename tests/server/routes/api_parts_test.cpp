#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "server/http/multipart.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

using Files = std::vector<std::pair<std::string, std::string>>;

std::string form_of(const Files& files) {
  std::string body;
  for (const auto& [name, bytes] : files) {
    body += "--x'y\r\nContent-Type: application/octet-stream\r\ncontent-disposition: form-data; ";
    body += "name=\"files\"; filename=\"" + name + "\"\r\n\r\n" + bytes + "\r\n";
  }
  return body + "--x'y--\r\n";
}

HttpResponse send(Service& service, const std::string& body) {
  return service.ask("POST", "/v1/meshes", body,
                     {{"Content-Type", "multipart/form-data; boundary=\"x'y\""}});
}

const std::string kDocument = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],
  "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
  "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
  "bufferViews":[{"buffer":0,"byteLength":36}],
  "buffers":[{"byteLength":36,"uri":"my%20mesh.bin"}]})";

std::string positions() {
  const float xyz[] = {0, 0, 0, 3, 0, 0, 0, 4, 0};
  return {reinterpret_cast<const char*>(xyz), sizeof xyz};
}

}  // namespace

TEST_CASE("AFormsFileNamesItsMesh") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const Files parts{{"scenes/my mesh.gltf", kDocument}, {"my mesh.bin", positions()}};
  CHECK(body_of(send(service, form_of(parts)))["name"] == "my mesh.gltf");
  CHECK(body_of(send(service, form_of({{"a/b.glb", glb_of(shapes::plane(4, 4))}})))["name"] ==
        "b.glb");
  // What can be no name is none, and no error.
  const json unnamed =
      body_of(send(service, form_of({{std::string(300, 'a'), glb_of(shapes::plane(5, 4))}})));
  CHECK(unnamed["vertices"] == 20);
  CHECK_FALSE(unnamed.contains("name"));
}

TEST_CASE("AGltfAndItsBuffersAreOneMesh") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const Files files{{"mesh.gltf", kDocument}, {"my mesh.bin", positions()}, {"wood.png", "?"}};
  const HttpResponse first = send(service, form_of(files));
  CHECK(first.status == 201);
  const json mesh = body_of(first);
  CHECK(mesh["format"] == "glb");
  CHECK(mesh["area"] == 6);
  // What is stored is a GLB of its own, which is the same mesh when it is sent.
  const std::string glb =
      *service.get("/v1/meshes/" + mesh["id"].get<std::string>() + "/source").body;
  CHECK(glb.starts_with("glTF"));
  CHECK(mesh["id"].get<std::string>() == sha256_hex(glb));
  CHECK(service.ask("POST", "/v1/meshes", glb).status == 200);
  const Files reordered{{"my mesh.bin", positions()}, {"mesh.gltf", kDocument}};
  CHECK(send(service, form_of(reordered)).status == 200);
}

TEST_CASE("AFormWithOneFileIsThatFile") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(shapes::plane(3, 3));
  const HttpResponse sent = send(service, "before\r\n" + form_of({{"plane.glb", glb}}) + "after");
  CHECK(sent.status == 201);
  CHECK(body_of(sent)["id"] == sha256_hex(glb));
}

TEST_CASE("AMissingBufferIsNamed") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const HttpResponse missing = send(service, form_of({{"mesh.gltf", kDocument}, {"b.bin", ""}}));
  CHECK(missing.status == 422);
  CHECK(body_of(missing)["code"] == "external_uri");
  CHECK(body_of(missing)["detail"].get<std::string>().find("my%20mesh.bin") != std::string::npos);
}

TEST_CASE("FormsThatAreNoneAre400") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string good = form_of({{"mesh.gltf", kDocument}, {"my mesh.bin", positions()}});
  const std::string field = "--x'y\r\nContent-Disposition: form-data; name=a\r\n\r\n1\r\n--x'y--";
  for (const std::string& body :
       {std::string(), std::string("--x'y"), good.substr(0, good.size() / 2),
        std::string("--x'y\r\n\r\nbytes\r\n--x'y--"), std::string("--x'yz\r\n--x'y--"), field,
        form_of({{"a.gltf", kDocument}, {"b.gltf", kDocument}}),
        form_of({{"a.bin", "1"}, {"a.bin", "2"}}), form_of({{"a.bin", "1"}, {"b.bin", "2"}})}) {
    CAPTURE(body);
    const HttpResponse refused = send(service, body);
    CHECK(refused.status == 400);
    CHECK(body_of(refused)["parameter"] == "body");
  }
  const HttpResponse unbounded =
      service.ask("POST", "/v1/meshes", good, {{"Content-Type", "multipart/form-data"}});
  CHECK(unbounded.status == 400);
  CHECK(body_of(unbounded)["parameter"] == "Content-Type");
}

TEST_CASE("PartsAreReadAsTheyWereWritten") {
  CHECK(multipart_boundary("multipart/form-data; charset=x; Boundary=abc") == "abc");
  CHECK(multipart_boundary("Multipart/Form-Data;boundary=\"a;b\"") == "a;b");
  CHECK_FALSE(multipart_boundary("multipart/mixed; boundary=abc"));
  CHECK_FALSE(multipart_boundary("multipart/form-data; boundary=" + std::string(71, 'a')));
  const std::string body =
      "--b\r\nContent-Disposition: form-data; filename=\"a;%22b.bin\"; name=n\r\n\r\n"
      "1\r\n--c\r\n\r\n--b \r\nX: y\r\nContent-Disposition: form-data; name=\"m\"\r\n\r\n\r\n--b--";
  const auto parts = read_multipart(body, "b");
  REQUIRE(parts);
  REQUIRE(parts->size() == 2);
  CHECK(parts->at(0).filename == "a;\"b.bin");
  CHECK(parts->at(0).name == "n");
  CHECK(parts->at(0).bytes == "1\r\n--c\r\n");
  CHECK(parts->at(1).filename.empty());
  CHECK(parts->at(1).bytes.empty());
  // Quotes as curl escapes them, a path as old browsers sent it, and quotes that do not close.
  const std::pair<std::string, std::string> file_names[] = {
      {R"("a\"b.obj")", "a\"b.obj"},
      {R"("C:\x\y.obj")", "C:\\x\\y.obj"},
      {R"("a)", ""},
      // Browsers escape no backslash, others do.
      {R"("a\")", "a\\"},
      {R"("a\\")", "a\\"},
      {R"("a\"")", "a\""},
      {R"("\")", "\\"}};
  for (const auto& [written, meant] : file_names) {
    const auto part = read_multipart(
        "--b\r\nContent-Disposition: form-data; filename=" + written + "\r\n\r\n1\r\n--b--", "b");
    REQUIRE(part);
    CHECK(part->at(0).filename == meant);
  }
  for (std::size_t size = 0; size < body.size(); ++size) {
    CHECK_FALSE(read_multipart(std::string_view(body).substr(0, size), "b"));
  }
}
