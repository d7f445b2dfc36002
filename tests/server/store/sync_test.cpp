// What a loss of power leaves of a store in a directory. The calls that change names or
// sync them are defined here, where they note what they are asked before they pass it on,
// and fail when they are told to. What was noted says which names are on the disk: those
// whose directory was synced after they were made.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "server/base/sha256.h"
#include "server/config/config.h"
#include "server/store/mesh_store.h"
#include "server/store/open_store.h"

using namespace geodesic;
using namespace geodesic::server;
namespace fs = std::filesystem;

namespace {

struct Call {
  enum class Kind { make, move, remove, sync } kind;
  std::string path;
  std::string from;  // of a move
};

struct Notes {
  std::mutex mutex;
  std::vector<Call> calls;
  int syncs_until_failure = -1;  // that many succeed, one fails; negative: none does
};
Notes& notes() {
  static Notes kept;
  return kept;
}

void note(Call::Kind kind, const std::string& path, const std::string& from = {}) {
  const std::lock_guard lock(notes().mutex);
  notes().calls.push_back({kind, path, from});
}

std::string path_of(int descriptor) {
  std::error_code error;
  return fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error).string();
}

int answered(long result) { return static_cast<int>(result); }

}  // namespace

extern "C" {

int fsync(int descriptor) {
  {
    const std::lock_guard lock(notes().mutex);
    if (notes().syncs_until_failure >= 0 && notes().syncs_until_failure-- == 0) {
      errno = EIO;
      return -1;
    }
  }
  const int result = answered(::syscall(SYS_fsync, descriptor));
  if (result == 0) note(Call::Kind::sync, path_of(descriptor));
  return result;
}

int mkdir(const char* path, mode_t mode) noexcept {
  const int result = answered(::syscall(SYS_mkdirat, AT_FDCWD, path, mode));
  if (result == 0) note(Call::Kind::make, path);
  return result;
}

int rename(const char* from, const char* to) noexcept {
  const int result = answered(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
  if (result == 0) note(Call::Kind::move, to, from);
  return result;
}

int unlink(const char* path) noexcept {
  const int result = answered(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
  if (result == 0) note(Call::Kind::remove, path);
  return result;
}

}  // extern "C"

namespace {

// The last call of a kind for a path before a place in the notes; -1 if there is none.
int last(Call::Kind kind, const std::string& path, int before) {
  const std::vector<Call>& calls = notes().calls;
  for (int i = before - 1; i >= 0; --i) {
    if (calls[static_cast<std::size_t>(i)].kind == kind &&
        calls[static_cast<std::size_t>(i)].path == path) {
      return i;
    }
  }
  return -1;
}

// Whether a name was made, or removed, for good: its directory was synced since.
bool is_settled(const fs::path& path) {
  const int end = static_cast<int>(notes().calls.size());
  int changed = -1;
  for (const Call::Kind kind : {Call::Kind::make, Call::Kind::move, Call::Kind::remove}) {
    changed = std::max(changed, last(kind, path.string(), end));
  }
  return last(Call::Kind::sync, path.parent_path().string(), end) > changed;
}

// Whether a file and all names that lead to it below `top` would outlive a loss of power.
bool is_durable(const fs::path& file, const fs::path& top) {
  const int moved = last(Call::Kind::move, file.string(), static_cast<int>(notes().calls.size()));
  if (moved < 0) return false;
  const std::string& temporary = notes().calls[static_cast<std::size_t>(moved)].from;
  if (last(Call::Kind::sync, temporary, moved) < last(Call::Kind::remove, temporary, moved)) {
    return false;
  }
  if (last(Call::Kind::sync, temporary, moved) < 0) return false;
  for (fs::path path = file; path != top; path = path.parent_path()) {
    if (!is_settled(path)) {
      MESSAGE(path.string() << " would be gone");
      return false;
    }
  }
  return true;
}

struct Folder {
  Folder() {
    std::string pattern = (fs::temp_directory_path() / "store_sync_XXXXXX").string();
    REQUIRE(::mkdtemp(pattern.data()) != nullptr);
    path = pattern;
    notes().calls.clear();
    notes().syncs_until_failure = -1;
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

Result<std::unique_ptr<MeshStore>> open(const fs::path& path) {
  return open_store(path.string(), {}, process_environment());
}

const std::string kBytes = "the bytes";
const std::string kId = sha256_hex(kBytes);

fs::path object(const fs::path& root) { return root / "objects" / kId.substr(0, 2) / kId; }
fs::path meta(const fs::path& root) { return root / "meta" / kId.substr(0, 2) / (kId + ".json"); }

void check_durable(const Folder& folder, const fs::path& root) {
  CHECK(is_durable(object(root), folder.path));
  CHECK(is_durable(meta(root), folder.path));
}

}  // namespace

TEST_CASE("what a new store acknowledges is on the disk, and so are all folders above it") {
  const Folder folder;
  const fs::path root = folder.path / "some" / "where" / "store";
  const auto store = open(root);
  REQUIRE(store);
  REQUIRE((*store)->put(kId, kBytes, "{}"));
  check_durable(folder, root);
}

TEST_CASE("folders that a process made and did not live to sync are synced by the next") {
  const Folder folder;
  const fs::path root = folder.path / "some" / "store";
  fs::create_directories(root / "objects" / kId.substr(0, 2));
  fs::create_directories(root / "meta" / kId.substr(0, 2));
  notes().calls.clear();
  const auto store = open(root);
  REQUIRE(store);
  REQUIRE((*store)->put(kId, kBytes, "{}"));
  check_durable(folder, root);
}

TEST_CASE("when any sync fails there is an error, and what is acknowledged later is on the disk") {
  bool failed = true;
  for (int sync = 0; failed; ++sync) {
    CAPTURE(sync);
    const Folder folder;
    const fs::path root = folder.path / "some" / "store";
    notes().syncs_until_failure = sync;
    auto store = open(root);
    bool acknowledged = store && (*store)->put(kId, kBytes, "{}");
    failed = notes().syncs_until_failure < 0;
    if (!acknowledged) {
      if (!store) store = open(root);
      REQUIRE(store);
      acknowledged = static_cast<bool>((*store)->put(kId, kBytes, "{}"));
    }
    REQUIRE(acknowledged);
    check_durable(folder, root);
    REQUIRE(sync < 100);
  }
}

TEST_CASE("a removal that is acknowledged is on the disk, also the second time") {
  for (const bool fails_first : {false, true}) {
    CAPTURE(fails_first);
    const Folder folder;
    const auto store = open(folder.path / "store");
    REQUIRE(store);
    REQUIRE((*store)->put(kId, kBytes, "{}"));
    if (fails_first) {
      notes().syncs_until_failure = 0;
      CHECK_FALSE((*store)->remove(kId));
    }
    CHECK((*store)->remove(kId));
    CHECK_FALSE(fs::exists(object(folder.path / "store")));
    CHECK(is_settled(object(folder.path / "store")));
  }
}
