// Prepared meshes in files: the same mesh comes back, and nothing else ever does.
#include "server/prepared/prepared_files.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/solve/distances.h"
#include "core/surface/intrinsic_delaunay.h"
#include "server/prepared/format.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/prepared/prepared_fixture.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;

TEST_CASE("APreparedMeshComesBackAsItWas") {
  std::vector<TriangleSoup> soups;
  for (const auto& awkward : fixtures::awkward_meshes()) soups.push_back(awkward.soup);
  for (std::uint32_t i = 0; i < 60; ++i) {
    soups.push_back(fixtures::RandomMesh(test_seed() + i).soup());
  }
  const TemporaryFolder folder;
  std::size_t with_flips = 0;
  std::size_t pinched = 0;
  for (std::size_t i = 0; i < soups.size(); ++i) {
    CAPTURE(i);
    const auto adjacency = prepared(soups[i]);
    with_flips += adjacency->parts().delaunay != nullptr ? 1 : 0;
    pinched += adjacency->parts().pinched.empty() ? 0 : 1;
    const std::string id = kId + std::to_string(i);
    {
      const auto files = opened(folder);
      files->keep(id, adjacency);
      files->wait();
      CHECK(files->stats().written == 1);
    }
    const auto files = opened(folder);  // as after a restart
    const auto found = files->find(id, kNeverStop);
    REQUIRE(found);
    REQUIRE(*found);
    fixtures::check_same(*adjacency, **found);
    files->erase(id);
    CHECK(count_files(folder) == 0);  // what is mapped stays
    fixtures::check_same(*adjacency, **found);
    const auto gone = files->find(id, kNeverStop);
    CHECK((gone && !*gone));
  }
  CHECK(with_flips > 10);
  CHECK(pinched > 0);
}

TEST_CASE("WhatIsDamagedIsNeverUsed") {
  std::mt19937 random(test_seed());
  const TemporaryFolder folder;
  const auto adjacency = prepared(fixtures::RandomMesh(test_seed()).soup());
  const auto files = opened(folder);
  const auto write = [&] {
    files->keep(kId, adjacency);
    files->wait();
  };
  write();
  const std::filesystem::path path = only_file(folder);
  const std::string whole = bytes_of_file(path);
  REQUIRE(whole.size() == prepared_bytes(*adjacency));
  const auto check_unused = [&](const std::string& bytes) {
    set_contents(path, bytes);
    const auto found = files->find(kId, kNeverStop);
    REQUIRE(found);
    CHECK(!*found);
    CHECK(count_files(folder) == (bytes.empty() ? 1 : 0));  // an empty one cannot be mapped
  };
  for (int i = 0; i < 400; ++i) {
    // Half of them in the head, where each byte means something else.
    const std::size_t at = random() % (i % 2 == 0 ? whole.size() : 512);
    const auto bit = random() % 8;
    CAPTURE(at);
    CAPTURE(bit);
    std::string flipped = whole;
    flipped[at] = static_cast<char>(static_cast<unsigned char>(flipped[at]) ^ (1U << bit));
    check_unused(flipped);
  }
  for (int i = 0; i < 60; ++i) {
    const std::size_t size = random() % whole.size();
    CAPTURE(size);
    check_unused(whole.substr(0, size));
    const std::string not_yet_on_disk =
        whole.substr(0, size) + std::string(whole.size() - size, '\0');
    if (not_yet_on_disk != whole) check_unused(not_yet_on_disk);  // it may end with zeros
  }
  check_unused(whole + std::string(64, '\0'));
  check_unused(std::string(whole.size(), '\0'));
  check_unused("");
  CHECK(files->stats().found == 0);
  write();  // in its place
  const auto again = files->find(kId, kNeverStop);
  REQUIRE((again && *again));
  fixtures::check_same(*adjacency, **again);
}

TEST_CASE("AnotherBuildAndAnotherMeshAreNotTakenForThisOne") {
  const TemporaryFolder folder;
  const auto adjacency = prepared(shapes::terrain(8, 2, test_seed()));
  const auto files = opened(folder);
  files->keep(kId, adjacency);
  files->wait();
  const std::string bytes = bytes_of_file(only_file(folder));
  const auto other_build = opened(folder, {}, std::string(31, '1') + "2");  // the same first digits
  const auto found = other_build->find(kId, kNeverStop);
  CHECK((found && !*found));
  // A file under another's name.
  const std::string other(64, 'b');
  set_contents(folder.path() / "geodesicd-prepared" / (other + "." + std::string(12, '1')), bytes);
  const auto wrong = files->find(other, kNeverStop);
  CHECK((wrong && !*wrong));
}

TEST_CASE("OfSeveralBuildsEachHasItsOwn") {
  const TemporaryFolder folder;
  const auto adjacency = prepared(shapes::terrain(8, 2, test_seed()));
  const auto one = opened(folder, {}, std::string(32, '1'));
  const auto other = opened(folder, {}, std::string(32, '2'));
  for (const auto* files : {&one, &other}) {
    (*files)->keep(kId, adjacency);
    (*files)->wait();
  }
  CHECK(count_files(folder) == 2);
  for (const auto* files : {&one, &other}) {
    const auto found = (*files)->find(kId, kNeverStop);
    CHECK((found && *found));
  }
  one->erase(kId);
  CHECK(count_files(folder) == 0);
}

TEST_CASE("WhatWasUsedLongestAgoMakesRoom") {
  std::mt19937 random(test_seed());
  const TemporaryFolder folder;
  const TriangleSoup soup = shapes::terrain(20, 2, test_seed());
  const std::uint64_t size = prepared_bytes(*prepared(soup));
  const std::uint64_t room = 4 * size + size / 2;
  const auto id_of = [](int at) { return std::string(63, '0') + "0123456789abcdef"[at]; };
  const auto path_of = [&](int at) {
    return folder.path() / "geodesicd-prepared" / (id_of(at) + "." + std::string(12, '1'));
  };
  const auto keep = [&](PreparedFiles& files, const std::string& id, const TriangleSoup& of) {
    const auto adjacency = prepared(of);  // held by nobody afterwards
    files.keep(id, adjacency);
    files.wait();
  };
  const auto files = opened(folder, {.bytes = room, .fewest_faces = 0});
  std::time_t used = std::time(nullptr) - 1000;
  std::vector<int> order;  // by their last use
  for (int at = 0; at < 12; ++at) {
    CAPTURE(at);
    keep(*files, id_of(at), soup);
    if (order.size() == 4) order.erase(order.begin());
    order.push_back(at);
    // One of them is used; times of files are set so that seconds need not pass.
    const auto again = order.begin() + static_cast<std::ptrdiff_t>(random() % order.size());
    const auto found = files->find(id_of(*again), kNeverStop);
    CHECK((found && *found));
    std::rotate(again, again + 1, order.end());
    for (const int present : order) {
      CAPTURE(present);
      const timespec times[2] = {{used, 0}, {used, 0}};
      ++used;
      CHECK(::utimensat(AT_FDCWD, path_of(present).c_str(), times, 0) == 0);
    }
    CHECK(count_files(folder) == order.size());
    CHECK(files->stats().bytes <= room);
  }
  SUBCASE("nothing goes for what would not fit even so") {
    const TriangleSoup large = shapes::terrain(60, 2, test_seed());
    REQUIRE(prepared_bytes(*prepared(large)) > room);
    keep(*files, kId, large);
    CHECK(files->stats().not_written == 1);
    CHECK(count_files(folder) == 4);
  }
  SUBCASE("a mesh that somebody holds is in use, though nobody reads its file") {
    const int oldest = order.front();
    auto held = files->find(id_of(oldest), kNeverStop);
    REQUIRE((held && *held));
    const timespec long_ago[2] = {{used - 8 * 24 * 3600, 0}, {used - 8 * 24 * 3600, 0}};
    REQUIRE(::utimensat(AT_FDCWD, path_of(oldest).c_str(), long_ago, 0) == 0);
    files->tidy();
    CHECK(std::filesystem::exists(path_of(oldest)));
    for (int more = 12; more < 15; ++more) keep(*files, id_of(more), soup);
    CHECK(std::filesystem::exists(path_of(oldest)));
    *held = nullptr;
    REQUIRE(::utimensat(AT_FDCWD, path_of(oldest).c_str(), long_ago, 0) == 0);
    files->tidy();
    CHECK(!std::filesystem::exists(path_of(oldest)));
  }
}

TEST_CASE("WhatIsNotOursStays") {
  const TemporaryFolder folder;
  REQUIRE(std::filesystem::create_directory(folder.path() / "geodesicd-prepared"));
  const std::vector<std::string> names{"thesis.odt",
                                       ".hidden",
                                       std::string(64, 'a'),
                                       std::string(64, 'g') + ".111111111111",
                                       std::string(64, 'a') + ".1111",
                                       kId + ".111111111111.txt"};
  for (const std::string& name : names) {
    const auto path = folder.path() / "geodesicd-prepared" / name;
    set_contents(path, std::string(100'000, 'x'));
    const timespec long_ago[2] = {{1000, 0}, {1000, 0}};
    REQUIRE(::utimensat(AT_FDCWD, path.c_str(), long_ago, 0) == 0);
  }
  const auto files = opened(folder, {.bytes = 1000, .fewest_faces = 0});
  const auto adjacency = prepared(shapes::plane(9, 9));
  files->keep(kId, adjacency);
  files->wait();
  files->erase(kId);
  CHECK(count_files(folder) == names.size());
}

TEST_CASE("WhatNobodyHasUsedForAWeekGoesAndSoDoesWhatWasNotFinished") {
  const TemporaryFolder folder;
  const auto adjacency = prepared(shapes::terrain(8, 2, test_seed()));
  {
    const auto files = opened(folder);
    files->keep(kId, adjacency);
    files->wait();
  }
  const auto set_age = [](const std::filesystem::path& path, std::time_t seconds) {
    const std::time_t then = std::time(nullptr) - seconds;
    const timespec times[2] = {{then, 0}, {then, 0}};
    REQUIRE(::utimensat(AT_FDCWD, path.c_str(), times, 0) == 0);
  };
  const auto open_and_look = [&](const std::string& id) {
    const auto files = opened(folder);
    files->keep(id, adjacency);  // makes room first
    files->wait();
    files->erase(id);
  };
  const std::string other(64, 'b');
  const auto path = only_file(folder);
  set_age(path, 6 * 24 * 3600);
  const auto part = folder.path() / "geodesicd-prepared" / (kId + ".111111111111.70f.part");
  set_contents(part, "begun");
  open_and_look(other);
  CHECK(std::filesystem::exists(path));
  CHECK(std::filesystem::exists(part));  // it may still be written
  set_age(part, 2 * 3600);
  open_and_look(other);
  CHECK(std::filesystem::exists(path));
  CHECK(!std::filesystem::exists(part));
  set_age(path, 8 * 24 * 3600);
  open_and_look(other);
  CHECK(!std::filesystem::exists(path));
}

TEST_CASE("NobodyElseMayWriteThere") {
  const TemporaryFolder folder;
  const std::filesystem::path own = folder.path() / "geodesicd-prepared";
  SUBCASE("what others may write to is taken from them") {
    REQUIRE(std::filesystem::create_directory(own));
    REQUIRE(::chmod(own.c_str(), 02777) == 0);
    const auto files = opened(folder);
    CHECK(std::filesystem::status(own).permissions() == std::filesystem::perms::owner_all);
    return;
  }
  SUBCASE("a link") {
    REQUIRE(std::filesystem::create_directory(folder.path() / "elsewhere"));
    std::filesystem::create_directory_symlink(folder.path() / "elsewhere", own);
  }
  SUBCASE("a file") { set_contents(own, "in the way"); }
  const auto files = PreparedFiles::open(folder.path(), {}, "1");
  REQUIRE(!files);
  CHECK(files.error().detail.find(folder.path().string()) != std::string::npos);
}

TEST_CASE("AFileThatOthersMayWriteIsNotUsed") {
  const TemporaryFolder folder;
  const auto files = opened(folder);
  files->keep(kId, prepared(shapes::terrain(8, 2, test_seed())));
  const auto adjacency = prepared(shapes::terrain(8, 2, test_seed()));
  files->keep(kId, adjacency);
  files->wait();
  const auto path = only_file(folder);
  REQUIRE(::chmod(path.c_str(), 0666) == 0);
  const auto open = files->find(kId, kNeverStop);
  CHECK((open && !*open));
  REQUIRE(::chmod(path.c_str(), 0600) == 0);
  const auto found = files->find(kId, kNeverStop);
  CHECK((found && *found));
}

TEST_CASE("ReadingAndWritingStopWhenTheyAreTold") {
  const TemporaryFolder folder;
  const auto adjacency = prepared(shapes::terrain(30, 2, test_seed()));
  const auto files = opened(folder);
  files->keep(kId, adjacency);
  files->wait();
  const auto found = files->find(kId, [] { return true; });
  REQUIRE(!found);
  CHECK(found.error().code == ErrorCode::cancelled);
  CHECK(count_files(folder) == 1);  // it is not damaged

  const std::filesystem::path path = folder.path() / "stopped";
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  REQUIRE(file >= 0);
  int asked = 0;
  const auto written = write_prepared(file, {kId, "1"}, *adjacency, [&] { return ++asked > 3; });
  ::close(file);
  REQUIRE(!written);
  CHECK(written.error().code == ErrorCode::cancelled);
  // Even by somebody who believes its checksum to be right.
  const std::string bytes = bytes_of_file(path);
  const auto aligned = std::make_shared<std::vector<FaceRecord>>(bytes.size() / 64 + 1);
  std::memcpy(static_cast<void*>(aligned->data()), bytes.data(), bytes.size());
  const auto all = std::as_bytes(std::span(*aligned)).first(bytes.size());
  PreparedChecksum checksum;
  checksum.add(0, all);
  CHECK(!read_prepared(all, aligned, {kId, "1"}, checksum));
}

TEST_CASE("WhatNobodyHoldsAnyMoreAndWhatIsSmallIsNotWritten") {
  const TemporaryFolder folder;
  const auto files = opened(folder, {.bytes = 0, .fewest_faces = 100});
  files->keep(kId, prepared(shapes::plane(20, 20)));  // gone by now
  files->wait();
  const auto small = prepared(shapes::plane(5, 5));
  files->keep(kId, small);
  files->wait();
  const std::size_t before = count_files(folder);
  CHECK(before <= 1);  // the writer may have been quicker
  const auto large = prepared(shapes::plane(20, 20));
  files->keep(std::string(64, 'b'), large);
  files->wait();
  CHECK(count_files(folder) == before + 1);
}

TEST_CASE("ManyMayUseTheFilesAtOnce") {
  const TemporaryFolder folder;
  std::vector<std::shared_ptr<const Adjacency>> meshes;
  std::vector<std::vector<double>> distances;
  for (std::uint32_t i = 0; i < 4; ++i) {
    meshes.push_back(prepared(shapes::terrain(6 + i, 2, test_seed() + i)));
  }
  const std::uint64_t size = prepared_bytes(*meshes.back());
  // Two processes would do the same.
  const auto one = opened(folder, {.bytes = 3 * size, .fewest_faces = 0});
  const auto other = opened(folder, {.bytes = 3 * size, .fewest_faces = 0});
  std::atomic<int> wrong{0};
  std::atomic<int> found{0};
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      std::mt19937 random(test_seed() + t);
      for (int i = 0; i < 150; ++i) {
        PreparedFiles& files = t % 2 == 0 ? *one : *other;
        const std::size_t at = random() % meshes.size();
        const std::string id(64, static_cast<char>('a' + at));
        const auto doing = random() % 8;
        if (doing == 0) {
          files.erase(id);
        } else if (doing < 4) {
          files.keep(id, meshes[at]);
        } else {
          const auto mapped = files.find(id, kNeverStop);
          if (!mapped || !*mapped) continue;
          ++found;
          if (!fixtures::has_same_bytes((*mapped)->parts().faces, meshes[at]->parts().faces))
            ++wrong;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  MESSAGE(found.load(), " found");
  one->wait();
  other->wait();
  one->keep(std::string(64, 'a'), meshes[0]);
  one->wait();
  const auto last = other->find(std::string(64, 'a'), kNeverStop);
  REQUIRE((last && *last));
  fixtures::check_same(*meshes[0], **last);
  CHECK(one->stats().damaged + other->stats().damaged == 0);
}

namespace {

struct WarmService : server::test::Service {
  WarmService(const TemporaryFolder& meshes, const TemporaryFolder& folder,
              const Config& config = {})
      : Service(meshes.path(), config), files(opened(folder)) {
    catalog.keep_prepared_in(*files);
  }
  // How often a step in making a mesh usable was taken.
  std::string steps(const std::string& step) {
    const std::string text = *get("/metrics").body;
    const std::string name = "geodesicd_mesh_duration_seconds_count{step=\"" + step + "\"} ";
    const std::size_t at = text.find(name);
    if (at == std::string::npos) return "0";
    const std::size_t begin = at + name.size();
    return text.substr(begin, text.find('\n', at) - begin);
  }

  std::unique_ptr<PreparedFiles> files;
};

}  // namespace

TEST_CASE("AServerThatStartsAgainAnswersOutOfTheFiles") {
  const TemporaryFolder store;
  const TemporaryFolder folder;
  const std::string glb =
      server::test::glb_of(fixtures::RandomMesh(test_seed() / 6 * 6).soup());  // a terrain
  std::string base;
  std::vector<HttpResponse> first;
  const std::vector<std::string> questions{"/distance?from=v:0&at=v:3",
                                           "/distance?from=v:1&method=exact",
                                           "/path?from=v:0&to=v:9", "/geometry?format=f32"};
  {
    WarmService server(store, folder);
    base = "/v1/meshes/" + server.upload(glb);
    server.files->wait();
    for (const std::string& question : questions) first.push_back(server.get(base + question));
    CHECK(server.steps("prepare") == "1");
    CHECK(server.steps("map") == "0");
  }
  {
    WarmService server(store, folder);
    for (std::size_t i = 0; i < questions.size(); ++i) {
      CAPTURE(questions[i]);
      const HttpResponse again = server.get(base + questions[i]);
      CHECK(again.status == first[i].status);
      CHECK(server::test::header_of(again, "ETag") == server::test::header_of(first[i], "ETag"));
      REQUIRE((again.body && first[i].body));
      CHECK(*again.body == *first[i].body);
    }
    CHECK(server.steps("prepare") == "0");
    CHECK(server.steps("decode") == "0");
    CHECK(server.steps("map") == "1");
    CHECK(server.ask("DELETE", base).status == 204);
    CHECK(count_files(folder) == 0);
    CHECK(server.get(base + questions[0]).status == 404);
  }
}

TEST_CASE("WhatIsDeletedWhileItIsPreparedLeavesNoFile") {
  std::mt19937 random(test_seed());
  const TemporaryFolder store;
  const TemporaryFolder folder;
  const std::string glb = server::test::glb_of(shapes::terrain(40, 2, test_seed()));
  Config nothing_kept;
  nothing_kept.mesh_cache_bytes = nothing_kept.adjacency_cache_bytes = 0;
  WarmService server(store, folder, nothing_kept);
  for (int i = 0; i < 30; ++i) {
    const std::string base = "/v1/meshes/" + server.upload(glb);
    std::thread asking([&] {
      for (int question = 0; question < 3; ++question)
        (void)server.get(base + "/distance?from=v:0&at=v:9");
    });
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 20'000));
    CHECK(server.ask("DELETE", base).status == 204);
    asking.join();
    server.files->wait();
    CHECK(count_files(folder) == 0);
  }
}

TEST_CASE("WhatAnotherServerHasDeletedIsForgottenHereTooOnceSomebodyAsks") {
  const TemporaryFolder store;
  const TemporaryFolder folder;
  WarmService server(store, folder);
  const std::string id = server.upload(server::test::glb_of(shapes::plane(9, 9)));
  server.files->wait();
  CHECK(count_files(folder) == 1);
  REQUIRE(server.store->remove(id));  // not by this server's routes
  CHECK(server.get("/v1/meshes/" + id + "/distance?from=v:0").status == 404);
  CHECK(count_files(folder) == 0);
  CHECK(server.catalog.adjacency_cache().entries == 0);
}

TEST_CASE("WhatIsNotInTheStoreIsNotServedOutOfTheFiles") {
  const TemporaryFolder store;
  const TemporaryFolder folder;
  WarmService server(store, folder);
  const std::string id = server.upload(server::test::glb_of(shapes::plane(9, 9)));
  server.files->wait();
  const TemporaryFolder other_store;  // of somebody else, or emptied since
  WarmService other(other_store, folder);
  CHECK(other.get("/v1/meshes/" + id + "/distance?from=v:0").status == 404);
}
