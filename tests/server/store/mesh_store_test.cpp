#include "server/store/mesh_store.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/config/config.h"
#include "server/store/open_store.h"
#include "tests/server/store/stored_files.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
namespace fs = std::filesystem;

namespace {

// A directory of its own that is gone after the test.
struct Folder {
  Folder() {
    std::string pattern = (fs::temp_directory_path() / "mesh_store_XXXXXX").string();
    REQUIRE(::mkdtemp(pattern.data()) != nullptr);
    path = pattern;
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

Result<std::unique_ptr<MeshStore>> open(const fs::path& path, const StoreBudget& budget = {}) {
  return open_store(path.string(), budget, process_environment());
}

fs::path meta_of(const fs::path& root, const std::string& id) {
  return root / "meta" / id.substr(0, 2) / (id + ".json");
}

void write(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string metadata_of(MeshStore& store, const std::string& id) {
  const auto metadata = store.get_metadata(id);
  REQUIRE(metadata);
  return metadata->value_or("(none)");
}

}  // namespace

TEST_CASE("SHA-256 of known texts") {
  CHECK(sha256_hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256_hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST_CASE("what was put comes back, also after a restart") {
  const Folder folder;
  const std::string bytes("glTF\0\xff mesh", 11);
  const std::string id = sha256_hex(bytes);
  {
    const auto store = opened(folder.path / "new" / "store");
    CHECK_FALSE(store->contains(id));
    REQUIRE(store->put(id, bytes, "{\"vertices\":3}"));
    CHECK(store->contains(id));
    CHECK(store->get_source(id) == bytes);
  }
  const auto store = opened(folder.path / "new" / "store");
  CHECK(store->size() == 1);
  CHECK(store->contains(id));
  CHECK(store->get_source(id) == bytes);
  CHECK(metadata_of(*store, id) == "{\"vertices\":3}");
  REQUIRE(store->put_metadata(id, "{}"));
  CHECK(metadata_of(*store, id) == "{}");
  CHECK(files_below(folder.path / "new" / "store" / "tmp") == 0);
}

TEST_CASE("an id that is no digest reaches no file") {
  const Folder folder;
  const auto store = opened(folder.path);
  const std::string id = sha256_hex("x");
  std::string upper = id;
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return std::toupper(c); });
  for (const std::string& bad :
       {std::string(), std::string("../../etc/passwd"), id.substr(1), id + "0", upper,
        "../" + id.substr(3), id.substr(0, 63) + "/", id.substr(0, 63) + std::string(1, '\0')}) {
    CAPTURE(bad);
    CHECK_FALSE(is_mesh_id(bad));
    CHECK_FALSE(store->contains(bad));
    CHECK(store->get_source(bad).error().code == ServiceCode::mesh_unknown);
    CHECK(store->get_metadata(bad).error().code == ServiceCode::mesh_unknown);
    CHECK(store->put(bad, "x", "").error().code == ServiceCode::mesh_unknown);
    CHECK(store->put_metadata(bad, "x").error().code == ServiceCode::mesh_unknown);
    CHECK(store->remove(bad) == false);
  }
  CHECK(store->get_source(id).error().code == ServiceCode::mesh_unknown);
  CHECK(store->put(id, "y", "").error().code == ServiceCode::digest_mismatch);
  CHECK(store->size() == 0);
  CHECK(files_below(folder.path) == 1);  // the lock
}

TEST_CASE("removing is idempotent and leaves nothing") {
  const Folder folder;
  const auto store = opened(folder.path);
  const std::string id = sha256_hex("x");
  REQUIRE(store->put(id, "x", "{}"));
  CHECK(store->remove(id) == true);
  CHECK_FALSE(store->contains(id));
  CHECK(store->remove(id) == false);
  CHECK(files_below(folder.path) == 1);
  REQUIRE(store->put(id, "x", "{}"));
  CHECK(store->get_source(id) == "x");
}

TEST_CASE("listing pages through sorted ids") {
  const Folder folder;
  const auto store = opened(folder.path);
  std::vector<std::string> ids;
  for (int i = 0; i < 25; ++i) {
    const std::string bytes = std::to_string(i);
    ids.push_back(sha256_hex(bytes));
    REQUIRE(store->put(ids.back(), bytes, "{}"));
  }
  std::sort(ids.begin(), ids.end());
  std::vector<std::string> listed;
  std::string after;
  while (true) {
    const std::vector<std::string> page = *store->list(after, 10);
    if (page.empty()) break;
    CHECK(page.size() <= 10);
    listed.insert(listed.end(), page.begin(), page.end());
    after = page.back();
  }
  CHECK(listed == ids);
}

TEST_CASE("what a crash left behind is cleared away or completed") {
  const Folder folder;
  const std::string id = sha256_hex("x");
  write(folder.path / "tmp" / "17", "half an upl");
  write(object_of(folder.path, id), "x");  // the metadata never came
  write(folder.path / "objects" / "zz" / "stray", "y");
  write(folder.path / "objects" / "stray", "y");
  write(folder.path / "objects" / "00" / id, "in the wrong shard");
  const auto store = opened(folder.path);
  CHECK(fs::is_empty(folder.path / "tmp"));
  CHECK(store->list("", 10) == std::vector<std::string>{id});
  CHECK(metadata_of(*store, id) == "(none)");
  CHECK(store->get_source(id) == "x");
  REQUIRE(store->put(id, "x", "{}"));
  CHECK(metadata_of(*store, id) == "{}");
}

TEST_CASE("damaged bytes are noticed, quarantined and can be uploaded again") {
  const Folder folder;
  const auto store = opened(folder.path);
  const std::string bytes = "a mesh of some length";
  const std::string id = sha256_hex(bytes);
  for (const std::string damage : {"truncated", "flipped", "emptied"}) {
    CAPTURE(damage);
    REQUIRE(store->put(id, bytes, "{}"));
    write(object_of(folder.path, id), damage == "truncated" ? "a mesh"
                                      : damage == "flipped" ? "a mesh of some lengtH"
                                                            : "");
    const auto got = store->get_source(id);
    REQUIRE_FALSE(got);
    CHECK(got.error().code == InputCode::store_corrupt);
    CHECK(got.error().detail.find(folder.path.string()) == std::string::npos);
    CHECK(fs::exists(folder.path / "quarantine" / id));
    CHECK_FALSE(store->contains(id));
    CHECK_FALSE(fs::exists(meta_of(folder.path, id)));
  }
  REQUIRE(store->put(id, bytes, "{}"));
  fs::remove(object_of(folder.path, id));
  CHECK(store->get_source(id).error().code == InputCode::store_corrupt);
  REQUIRE(store->put(id, bytes, "{}"));
  CHECK(store->get_source(id) == bytes);
}

TEST_CASE("when the disk fails nothing of the put remains and no path leaks") {
  const Folder folder;
  const auto store = opened(folder.path);
  const std::string id = sha256_hex("x");
  // A file where a directory should be fails for every user, root included.
  for (const char* part : {"objects", "meta"}) {
    CAPTURE(part);
    write(folder.path / part / id.substr(0, 2), "in the way");
    const auto stored = store->put(id, "x", "{}");
    REQUIRE_FALSE(stored);
    CHECK(stored.error().code == ServiceCode::store_failed);
    CHECK(stored.error().detail.find("Not a directory") != std::string::npos);
    CHECK(stored.error().detail.find(folder.path.string()) == std::string::npos);
    CHECK_FALSE(store->contains(id));
    CHECK(fs::is_empty(folder.path / "tmp"));
    CHECK_FALSE(fs::is_regular_file(object_of(folder.path, id)));
    fs::remove(folder.path / part / id.substr(0, 2));
  }
  fs::remove_all(folder.path / "tmp");
  CHECK(store->put(id, "x", "{}").error().code == ServiceCode::store_failed);
  fs::create_directory(folder.path / "tmp");
  CHECK(store->put(id, "x", "{}"));
}

TEST_CASE("a store that cannot be opened says so and where") {
  const Folder folder;
  write(folder.path / "file", "");
  const auto store = open(folder.path / "file");
  REQUIRE_FALSE(store);
  CHECK(store.error().code == ServiceCode::store_failed);
  CHECK(store.error().detail.find((folder.path / "file").string()) != std::string::npos);
  write(folder.path / "half" / "objects", "");
  CHECK_FALSE(open(folder.path / "half"));
}

TEST_CASE("one process at a time uses a store") {
  const Folder folder;
  auto store = opened(folder.path);
  const auto second = open(folder.path);
  REQUIRE_FALSE(second);
  CHECK(second.error().detail.find("another process uses it") != std::string::npos);
  std::fflush(nullptr);  // or the child might print what is buffered once more
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) ::_exit(open(folder.path) ? 1 : 0);
  int status = -1;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  store.reset();
  CHECK(open(folder.path));
}

TEST_CASE("puts, reads and removals of the same meshes at once do no harm") {
  const Folder folder;
  const auto store = opened(folder.path);
  std::vector<std::string> bytes;
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i) {
    bytes.push_back(std::string(10'000, static_cast<char>('a' + i)));
    ids.push_back(sha256_hex(bytes.back()));
  }
  std::vector<std::future<int>> workers;
  for (std::size_t t = 0; t < 6; ++t) {
    workers.push_back(std::async(std::launch::async, [&, t] {
      int wrong = 0;
      for (std::size_t i = 0; i < 40; ++i) {
        const std::size_t m = (i + t) % ids.size();
        if (t < 3) wrong += !store->put(ids[m], bytes[m], "{}");
        if (t == 3 && i % 4 == 0) wrong += !store->remove(ids[m]);
        const auto got = store->get_source(ids[m]);
        if (got ? *got != bytes[m] : got.error().code != ServiceCode::mesh_unknown) ++wrong;
      }
      return wrong;
    }));
  }
  for (auto& worker : workers) CHECK(worker.get() == 0);
  CHECK(files_below(folder.path / "quarantine") == 0);
  CHECK(files_below(folder.path / "tmp") == 0);
  CHECK(files_below(folder.path / "objects") == store->size());
}

TEST_CASE("ten thousand meshes are listed at the start, and none of them is opened") {
  const Folder folder;
  for (int i = 0; i < 10'000; ++i) {
    const std::string id = sha256_hex(std::to_string(i));
    const fs::path path = object_of(folder.path, id);
    fs::create_directories(path.parent_path());
    // A pipe would hold forever whoever opens it to read; only its name may be looked at.
    if (i == 5000) REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    if (i != 5000) std::ofstream(path, std::ios::binary) << "x";
  }
  const auto store = opened(folder.path);
  CHECK(store->size() == 9'999);
  CHECK(store->stats().bytes == 9'999);
}

TEST_CASE("metadata without a source is cleared away at the start") {
  const Folder folder;
  const std::string id = sha256_hex("x");
  write(meta_of(folder.path, id), "{}");
  const auto store = opened(folder.path);
  CHECK(store->size() == 0);
  CHECK_FALSE(fs::exists(meta_of(folder.path, id)));
}

TEST_CASE("every flipped bit of a source is noticed") {
  const Folder folder;
  const auto store = opened(folder.path);
  const std::string bytes = "twelve bytes";
  const std::string id = sha256_hex(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    CAPTURE(bit);
    REQUIRE(store->put(id, bytes, "{}"));
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    write(object_of(folder.path, id), damaged);
    const auto got = store->get_source(id);
    REQUIRE_FALSE(got);
    CHECK(got.error().code == InputCode::store_corrupt);
    CHECK(store->get_source(id).error().code == ServiceCode::mesh_unknown);
  }
  CHECK(store->stats().corrupt == 8 * bytes.size());
}

TEST_CASE("a damaged mesh that cannot be moved is not served either") {
  const Folder folder;
  const auto store = opened(folder.path);
  const std::string id = sha256_hex("x");
  REQUIRE(store->put(id, "x", "{}"));
  write(object_of(folder.path, id), "y");
  fs::remove_all(folder.path / "quarantine");
  write(folder.path / "quarantine", "a file in the way");
  CHECK(store->get_source(id).error().code == InputCode::store_corrupt);
  CHECK(store->get_source(id).error().code == ServiceCode::mesh_unknown);
  CHECK(store->stats().corrupt == 1);
  CHECK(store->stats().failures == 1);
}

TEST_CASE("AMeshThatIsBeingVerifiedHoldsUpNoOther") {
  using namespace std::chrono_literals;
  const Folder folder;
  const auto store = opened(folder.path);
  std::vector<std::string> ids;
  for (const char* bytes : {"the one", "another"}) {
    ids.push_back(sha256_hex(bytes));
    REQUIRE(store->put(ids.back(), bytes, "{}"));
  }
  std::promise<void> begun;
  std::promise<void> go_on;
  auto slow = std::async(std::launch::async, [&] {
    return store->open_source(ids[0], [&] {  // asked while it is read
      begun.set_value();
      go_on.get_future().wait();
      return false;
    });
  });
  begun.get_future().wait();
  auto other = std::async(std::launch::async,
                          [&] { return store->open_source(ids[1], [] { return false; }); });
  CHECK(other.wait_for(20s) == std::future_status::ready);
  // Who waits for the same one leaves with its client.
  auto gone = std::async(std::launch::async,
                         [&] { return store->open_source(ids[0], [] { return true; }); });
  CHECK(gone.wait_for(20s) == std::future_status::ready);
  auto waits = std::async(std::launch::async,
                          [&] { return store->open_source(ids[0], [] { return false; }); });
  go_on.set_value();
  for (auto* found : {&slow, &other, &waits}) {
    const auto file = found->get();
    REQUIRE(file);
    CHECK(*file);
  }
  const auto left = gone.get();
  REQUIRE_FALSE(left);
  CHECK(left.error().code == ErrorCode::cancelled);
}
