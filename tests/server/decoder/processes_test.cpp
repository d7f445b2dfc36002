// Files are decoded in processes of their own as they are in this one, and whatever a
// decoder does, it does to itself.
#include "server/decoder/processes.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/encode/encode_mesh.h"
#include "proto/gltf/annotate.h"
#include "proto/gltf/weights.h"
#include "server/base/service_codes.h"
#include "server/decoder/confine_process.h"
#include "server/decoder/decoded_frame.h"
#include "server/decoder/local_message.h"
#include "server/decoder/mesh_form.h"
#include "server/decoder/process.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace std::chrono_literals;
using geodesic::fixtures::is_soon;

namespace {

DecoderProcesses::Limits short_limits() {
  DecoderProcesses::Limits limits;
  limits.memory_bytes = std::uint64_t{256} << 20;
  limits.time = 60s;
  return limits;
}

std::string knot_file() {
  const std::vector<std::byte> bytes = proto::encode_glb(shapes::torus_knot(200, 20, 0.4), "knot");
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Decoded decoded_here(std::string_view bytes) {
  return proto::decode_mesh({reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()}, {});
}

std::vector<std::byte> frame_of(const Decoded& decoded) {
  std::vector<std::byte> frame(frame_size(decoded));
  write_frame(decoded, frame);
  return frame;
}

// A copy of the program that only this process runs: decoders are told by their program's file,
// and the same tests may run beside these.
const std::string& rogue_decoder() {
  static const test::TemporaryFolder folder;
  static const std::string program = [] {
    const auto copy = folder.path() / "rogue_decoder";
    std::filesystem::copy_file(ROGUE_DECODER, copy);
    return std::filesystem::canonical(copy).string();
  }();
  return program;
}

// The decoders of this test: the one that waits for orders, and its copies.
std::vector<pid_t> decoder_pids() {
  const std::filesystem::path program = rogue_decoder();
  std::vector<pid_t> pids;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::error_code error;
    const auto exe = std::filesystem::read_symlink(entry.path() / "exe", error);
    if (!error && exe == program) pids.push_back(std::stoi(entry.path().filename().string()));
  }
  return pids;
}

std::unique_ptr<DecoderProcesses> started(const DecoderProcesses::Limits& limits) {
  // Those of the test before may still be on their way out.
  REQUIRE(is_soon([] { return decoder_pids().empty(); }));
  auto processes = DecoderProcesses::start(rogue_decoder(), limits);
  REQUIRE(processes);
  return std::move(*processes);
}

}  // namespace

TEST_CASE("AFileIsDecodedAsInThisProcess") {
  const auto processes = started(short_limits());
  const std::string file = knot_file();
  const Decoded there = processes->decode(file, {}, {}, {});
  const Decoded here = decoded_here(file);
  REQUIRE(there);
  REQUIRE(here);
  CHECK(there->soup.positions.size() == 4000);
  CHECK(frame_of(there) == frame_of(here));
  CHECK(processes->stats().decoded == 1);
  CHECK(processes->stats().running == 0);
}

TEST_CASE("AFileIsAnnotatedAsInThisProcess") {
  const auto processes = started(short_limits());
  const std::string file = knot_file();
  const std::vector<proto::VertexAttribute> attributes{{"_A", 1}, {"_B", 3}};
  const auto there = processes->annotation(file, attributes, {}, {}, {});
  const auto here = proto::annotate_gltf(
      {reinterpret_cast<const std::byte*>(file.data()), file.size()}, {}, {}, attributes);
  REQUIRE(there);
  REQUIRE(here);
  CHECK(there->json == here->json);
  CHECK(there->values_at == here->values_at);
  CHECK(there->runs == here->runs);
  CHECK(there->runs == std::vector<proto::VertexRun>{{0, 4000}});
  const auto refused = processes->annotation("no mesh", attributes, {}, {}, {});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::mesh_invalid);
}

TEST_CASE("WeightsAreReadAsInThisProcess") {
  const auto processes = started(short_limits());
  const std::string file = knot_file();
  const auto there = processes->face_numbers(file, "_MUD", proto::FaceNumber::weight, {}, {}, {});
  const auto here =
      proto::read_face_numbers({reinterpret_cast<const std::byte*>(file.data()), file.size()}, {},
                               {}, "_MUD", proto::FaceNumber::weight);
  REQUIRE_FALSE(there);
  REQUIRE_FALSE(here);
  CHECK(there.error().detail == here.error().detail);
  CHECK(there.error().parameter == "weight_attribute");
}

TEST_CASE("AFilesFaultIsToldAsInThisProcess") {
  const auto processes = started(short_limits());
  const std::string file = knot_file();
  proto::DecodeLimits few;
  few.max_vertices = 100;
  const Decoded there = processes->decode(file, few, {}, {});
  REQUIRE_FALSE(there);
  CHECK(there.error().code == ErrorCode::too_many_vertices);
  CHECK(there.error().limit == 100);
  CHECK(there.error().actual == 4000);
  for (const std::string& bad : {file.substr(0, 100), std::string("{"), std::string()}) {
    CHECK(frame_of(processes->decode(bad, {}, {}, {})) == frame_of(decoded_here(bad)));
  }
  CHECK(processes->stats().refused == 5);  // one of them tried the processes out
}

TEST_CASE("WhateverADecoderDoesItDoesToItself") {
  const auto processes = started(short_limits());
  std::vector<std::string_view> deeds{"crash", "end", "hole"};
  // Sanitizers need system calls of their own, so nothing is confined with them.
  if (Confinement::can_confine()) {
    for (const char* deed : {"open", "connect", "fork", "run", "kill", "code"}) {
      deeds.emplace_back(deed);
    }
  }
  for (const std::string_view deed : deeds) {
    CAPTURE(deed);
    const Decoded refused = processes->decode(deed, {}, {}, {});
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::mesh_invalid);
    CHECK(refused.error().detail == "the decoder crashed on this file");
    CHECK(processes->decode(knot_file(), {}, {}, {}));
  }
  CHECK(processes->stats().crashed == deeds.size());
  CHECK(processes->stats().decoded == deeds.size());
}

TEST_CASE("AFileThatTakesTooMuchMemoryIsRefused") {
  if (!Confinement::can_confine()) return;
  const auto processes = started(short_limits());
  const Decoded refused = processes->decode("balloon", {}, {}, {});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(refused.error().limit == short_limits().memory_bytes);
  CHECK(processes->decode(knot_file(), {}, {}, {}));
}

TEST_CASE("AFileThatTakesTooLongIsRefusedAndItsDecoderKilled") {
  DecoderProcesses::Limits limits = short_limits();
  limits.time = 1s;
  const auto processes = started(limits);
  const Decoded refused = processes->decode("hang", {}, {}, {});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::mesh_invalid);
  CHECK(processes->stats().overtime == 1);
  CHECK(is_soon([] { return decoder_pids().size() == 1; }));
}

TEST_CASE("ADecoderIsKilledOnceNobodyWantsItsAnswer") {
  const auto processes = started(short_limits());
  std::atomic<bool> gone{false};
  std::thread leaving([&] {
    CHECK(is_soon([] { return decoder_pids().size() == 2; }));
    gone = true;
  });
  const Decoded refused = processes->decode("hang", {}, {}, Caller([&] { return gone.load(); }));
  leaving.join();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::cancelled);
  CHECK(processes->stats().cancelled == 1);
  CHECK(is_soon([] { return decoder_pids().size() == 1; }));
  Caller hurried;
  hurried.deadline = Caller::Clock::now() + 20ms;
  CHECK(processes->decode("hang", {}, {}, hurried).error().code == ServiceCode::deadline);
}

TEST_CASE("ADecoderEndsIfNobodyWantedItsAnswerFromTheStart") {
  REQUIRE(is_soon([] { return decoder_pids().empty(); }));
  auto [orders, theirs] = local_pair();
  REQUIRE(orders);
  const std::string argument(kDecoderArgument);
  const std::string& program = rogue_decoder();
  const pid_t process = ::fork();
  if (process == 0) {
    if (::dup2(theirs.get(), kDecoderSocket) != kDecoderSocket) ::_exit(1);
    if (theirs.get() == kDecoderSocket) ::fcntl(kDecoderSocket, F_SETFD, 0);
    ::execl(program.c_str(), program.c_str(), argument.c_str(), nullptr);
    ::_exit(1);
  }
  theirs.close();
  DecodeOrder order;
  order.memory_bytes = std::uint64_t{256} << 20;
  order.cpu_seconds = 3600;
  const auto send = [&](std::string_view wish, bool is_wanted) {
    const UniqueFd file(::memfd_create("mesh", MFD_CLOEXEC));
    const UniqueFd frame(::memfd_create("frame", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    REQUIRE(::write(file.get(), wish.data(), wish.size()) == static_cast<ssize_t>(wish.size()));
    order.file_bytes = wish.size();
    auto [mine, its] = local_pair();
    // Closed before the decoder can have asked for a signal.
    if (!is_wanted) mine.close();
    REQUIRE(send_message(orders.get(), write_order(order), {file.get(), frame.get(), its.get()}));
    its.close();
    if (is_wanted) CHECK(receive_message(mine.get(), 100));
  };
  for (int i = 0; i < 5; ++i) send("hang", false);
  send("no mesh", true);  // so all copies have been made
  CHECK(is_soon([] { return decoder_pids().size() == 1; }));
  orders.close();
  CHECK(::waitpid(process, nullptr, 0) == process);
  for (const pid_t left : decoder_pids()) ::kill(left, SIGKILL);
}

TEST_CASE("WhenTheDecoderProcessIsKilledAnotherIsStarted") {
  const auto processes = started(short_limits());
  // The copy that was made to try it out has to end yet.
  REQUIRE(is_soon([] { return decoder_pids().size() == 1; }));
  const std::vector<pid_t> pids = decoder_pids();
  REQUIRE(::kill(pids[0], SIGKILL) == 0);
  for (int i = 0; i < 3; ++i) CHECK(processes->decode(knot_file(), {}, {}, {}));
  CHECK(decoder_pids() != pids);
}

TEST_CASE("NoDecoderOutlivesItsServer") {
  { const auto processes = started(short_limits()); }
  CHECK(is_soon([] { return decoder_pids().empty(); }));
}

TEST_CASE("ManyDecodeAtOnce") {
  const auto processes = started(short_limits());
  const std::string file = knot_file();
  std::atomic<int> went{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 10; ++i) {
        const Decoded decoded = processes->decode(t == 0 ? std::string("crash") : file, {}, {}, {});
        if (decoded.has_value() == (t != 0)) ++went;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(went == 80);
  CHECK(processes->stats().crashed == 10);
}

TEST_CASE("AProgramThatIsNoDecoderIsFoundOutAtTheStart") {
  for (const char* program : {"/nowhere/at/all", "/bin/true"}) {
    CAPTURE(program);
    const auto processes = DecoderProcesses::start(program, short_limits());
    REQUIRE_FALSE(processes);
    CHECK(processes.error().code == ErrorCode::internal);
    CHECK(processes.error().detail.find("--decoder in-process") != std::string::npos);
  }
}

TEST_CASE("WhereNoProcessCanBeMadeTheFileIsNotToBlame") {
  const auto name = std::filesystem::temp_directory_path() /
                    ("geodesicd_" + std::to_string(::getpid()) + "_without-fork");
  std::filesystem::create_symlink(rogue_decoder(), name);
  const auto processes = DecoderProcesses::start(name, short_limits());
  std::filesystem::remove(name);
  REQUIRE_FALSE(processes);
  CHECK(processes.error().detail.find("no process to decode") != std::string::npos);
}

TEST_CASE("FramesSurviveTheWay") {
  proto::DecodedMesh mesh;
  mesh.format = proto::MeshFormat::drc;
  mesh.soup.positions = {{1, 2, 3}, {-0.0, 1e300, 5}, {7, 8, 9}};
  mesh.soup.faces = {{0, 1, 2}, {2, 1, 0}};
  mesh.parts = {{-1, -1, -1, "", 0, 1, 0, 1, -1}, {3, 4, 5, "n\xc3\xa4me", 1, 2, 1, 1, 7}};
  mesh.materials.names = {"", "glass"};
  mesh.materials.runs = {{1, proto::kNoMaterial}, {2, 7}};
  mesh.findings = {{"", 0, {}, ""}, {"code", 2, {"one", ""}, "text"}};
  const std::vector<std::byte> frame = frame_of(mesh);
  const auto read = read_frame(frame);
  REQUIRE(read);
  REQUIRE(*read);
  CHECK((*read)->parts[1].name == "n\xc3\xa4me");
  CHECK((*read)->parts[0].material == -1);
  CHECK((*read)->parts[1].material == 7);
  CHECK((*read)->materials.names == mesh.materials.names);
  REQUIRE((*read)->materials.runs.size() == 2);
  CHECK((*read)->materials.runs[0].material == proto::kNoMaterial);
  CHECK((*read)->materials.runs[1].end == 2);
  CHECK((*read)->findings[1].examples == mesh.findings[1].examples);
  CHECK((*read)->findings[1].text == "text");
  CHECK((*read)->format == proto::MeshFormat::drc);
  CHECK(frame_of(*read) == frame);
  for (const auto& [number, is_a_format] : {std::pair(0, true), {5, true}, {100, false}}) {
    mesh.format = static_cast<proto::MeshFormat>(number);
    CHECK(read_frame(frame_of(mesh)).has_value() == is_a_format);
  }

  const Error error{ErrorCode::too_large, "detail", "from[2]", 5, {}};
  const auto failed = read_frame(frame_of(fail(error)));
  REQUIRE(failed);
  CHECK(failed->error().code == error.code);
  CHECK(failed->error().detail == error.detail);
  CHECK(failed->error().parameter == error.parameter);
  CHECK(failed->error().limit == 5);
  CHECK_FALSE(failed->error().actual);

  // A file found in a form is no mesh, and a mesh is none.
  const Result<FormFile> file = FormFile{"a name", "bytes"};
  std::vector<std::byte> framed(frame_size(file));
  write_frame(file, framed);
  CHECK(read_frame<FormFile>(framed).value() == FormFile{"a name", "bytes"});
  CHECK_FALSE(read_frame(framed));
  CHECK_FALSE(read_frame<FormFile>(frame));
  CHECK_FALSE(read_frame<FormFile>({framed.data(), framed.size() - 1}));
}

TEST_CASE("ALargeFrameIsReadNoFurtherThanItIsWanted") {
  proto::DecodedMesh mesh;
  mesh.soup.positions.resize(1 << 20);  // three pieces
  const std::vector<std::byte> frame = frame_of(mesh);
  int questions = 0;
  CHECK(read_frame(frame, Cancel([&] { return ++questions < 0; })));
  REQUIRE(questions > 1);
  for (int k = 1; k <= questions; ++k) {
    int asked = 0;
    CHECK_FALSE(read_frame(frame, Cancel([&] { return ++asked == k; })));
    CHECK(asked == k);
  }
}

TEST_CASE("AFileIsFoundInItsFormAsItIsHere") {
  const auto processes = started(short_limits());
  const std::string head = "--b\r\nContent-Disposition: form-data; name=f; filename=";
  const std::string document =
      R"({"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":3}]})";
  const std::string good =
      head + "a.gltf\r\n\r\n" + document + "\r\n" + head + "a.bin\r\n\r\nxyz\r\n--b--";
  const std::string alone = head + "k.glb\r\n\r\n" + knot_file() + "\r\n--b--";
  for (const std::string& body : {good, alone, good.substr(0, good.size() / 2), std::string(),
                                  head + "a.gltf\r\n\r\n" + document + "\r\n--b--"}) {
    const auto there = processes->file_of_form(body, "b", {}, {});
    const auto here = file_of_form(body, "b", {});
    REQUIRE(there.has_value() == here.has_value());
    if (here) {
      CHECK(*there == *here);
    } else {
      CHECK(there.error().code == here.error().code);
      CHECK(there.error().detail == here.error().detail);
      CHECK(there.error().parameter == here.error().parameter);
    }
  }
  CHECK(processes->file_of_form(alone, "b", {}, {}) == FormFile{"k.glb", knot_file()});
  CHECK(processes->file_of_form(good, "b", {}, [] { return true; }).error().code ==
        ErrorCode::cancelled);
}

TEST_CASE("AFrameIsTakenForNothingThatItIsNot") {
  const std::vector<std::byte> frame = frame_of(decoded_here(knot_file()));
  for (std::size_t size = 0; size < frame.size(); size += 1 + size / 50) {
    CHECK_FALSE(read_frame({frame.data(), size}));
  }
  std::vector<std::byte> longer = frame;
  longer.push_back(std::byte{0});
  CHECK_FALSE(read_frame(longer));
  // Counts that lie, wherever they are: no crash, and no more memory than the frame has.
  std::mt19937 random(3);
  std::size_t taken = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<std::byte> damaged = frame;
    const std::size_t head = 64;
    const std::size_t tail = damaged.size() - 200;
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = random() % 2 == 0 ? random() % head : tail + random() % 200;
      damaged[at] = static_cast<std::byte>(random());
    }
    const auto read = read_frame(damaged);
    if (read) ++taken;
  }
  CHECK(taken < 3000);
}
