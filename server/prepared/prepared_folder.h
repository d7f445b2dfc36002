// The folder of prepared meshes' files: their names, the room that they may take, and how one
// appears.
//
// Several processes may use it. All methods may be called from any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/base/unique_fd.h"

namespace geodesic::server {

// A file that is being written, under a name of its own. It goes with this object unless it was
// given its name.
class PartFile {
 public:
  PartFile(PartFile&&) noexcept = default;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();

  [[nodiscard]] int descriptor() const { return file_.get(); }
  // Lets it appear, in place of one that is there. Errors: cancelled if another process has removed
  // it, for its mesh was deleted; store_failed.
  [[nodiscard]] Result<void> finish();

 private:
  friend class PreparedFolder;
  PartFile(int folder, UniqueFd file, std::string part, std::string name)
      : folder_(folder), file_(std::move(file)), part_(std::move(part)), name_(std::move(name)) {}

  int folder_;
  UniqueFd file_;
  std::string part_;  // empty: it has its name
  std::string name_;
};

class PreparedFolder {
 public:
  // Makes the directory, and the folder geodesicd-prepared in it. `max_bytes`: of all files; 0: no
  // limit. Errors: store_failed, with a sentence for the operator.
  [[nodiscard]] static Result<std::unique_ptr<PreparedFolder>> open(
      const std::filesystem::path& directory, std::uint64_t max_bytes);

  [[nodiscard]] static std::string name_of(std::string_view mesh, std::string_view engine);

  // Of the folder, for those who read its files.
  [[nodiscard]] const UniqueFd& descriptor() const { return folder_; }
  // Of the files that are whole or being written, and ours. Errors: store_failed.
  [[nodiscard]] Result<std::vector<std::string>> names() const;
  // It may be gone already. Errors: store_failed.
  [[nodiscard]] Result<void> remove(const std::string& name) const;
  // Sets the time of its use to now.
  void touch(const std::string& name) const;

  // A file of so many bytes, all of which have their room from now on: what was used longest ago
  // goes for it. The folder must outlive it. Errors: store_full, store_failed.
  [[nodiscard]] Result<PartFile> create(const std::string& name, std::uint64_t bytes);
  // Removes what is too old or too much. Errors: store_failed.
  [[nodiscard]] Result<void> tidy();
  // Of all files, when they were last counted.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  PreparedFolder(UniqueFd folder, std::uint64_t max_bytes)
      : folder_(std::move(folder)), max_bytes_(max_bytes) {}
  // Says whether `bytes` more have room, after others went.
  [[nodiscard]] Result<bool> make_room(std::uint64_t bytes);

  const UniqueFd folder_;
  const std::uint64_t max_bytes_;
  std::mutex making_room_;  // until what it is for is there
  std::atomic<std::uint64_t> bytes_{0};
};

}  // namespace geodesic::server
