#include "server/store/verified_files.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "server/base/sha256.h"
#include "server/store/mesh_id.h"

namespace geodesic::server {
namespace {

// By reading it. Errors: cancelled.
Result<bool> has_digest(const ReplyFile& file, std::string_view id,
                        const std::function<bool()>& stop) {
  Sha256 digest;
  std::string piece;
  for (std::uint64_t done = 0; done < file.size(); done += piece.size()) {
    if (stop()) return fail(ErrorCode::cancelled, "the client is gone");
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    piece.resize(kPiece);
    piece.resize(file.read(done, piece.data(), piece.size()));
    if (piece.empty()) return false;
    digest.add(piece);
  }
  return digest.hex() == source_digest(id);
}

}  // namespace

bool VerifiedFiles::is_verified(const std::string& id, const std::string& state) const {
  const auto known = verified_.find(id);
  return known != verified_.end() && known->second == state;
}

Result<bool> VerifiedFiles::is_whole(const ReplyFile& file, std::string_view id,
                                     const std::string& state, const std::function<bool()>& stop) {
  const std::string key(id);
  std::unique_lock lock(mutex_);
  while (verifying_.contains(key)) {
    constexpr std::chrono::milliseconds kAskEvery{50};
    if (verify_done_.wait_for(lock, kAskEvery) != std::cv_status::timeout) continue;
    lock.unlock();  // the question may take a system call
    if (stop()) return fail(ErrorCode::cancelled, "the client is gone");
    lock.lock();
  }
  if (is_verified(key, state)) return true;
  verifying_.insert(key);
  lock.unlock();
  Result<bool> is_whole = false;
  const auto end = [&] {
    lock.lock();
    verifying_.erase(key);
    verify_done_.notify_all();
  };
  try {
    is_whole = has_digest(file, id, stop);
  } catch (...) {
    end();
    throw;
  }
  end();
  if (!is_whole || !*is_whole) return is_whole;
  constexpr std::size_t kMostKept = 10'000;
  if (verified_.size() >= kMostKept) verified_.clear();
  verified_[key] = state;
  return true;
}

}  // namespace geodesic::server
