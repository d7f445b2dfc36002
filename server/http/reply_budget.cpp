#include "server/http/reply_budget.h"

#include <atomic>
#include <utility>

#include "server/base/client_shares.h"
#include "server/base/service_codes.h"

namespace geodesic::server {
namespace {

// Gives back to a share what it has taken of it.
class PartOfShare {
 public:
  explicit PartOfShare(std::shared_ptr<ReplyBudget::Share> share) : share_(std::move(share)) {}
  ~PartOfShare() { share_->shrink(share_->bytes() - bytes_); }
  PartOfShare(const PartOfShare&) = delete;
  PartOfShare& operator=(const PartOfShare&) = delete;
  [[nodiscard]] Result<void> take(std::uint64_t bytes) {
    auto grown = share_->grow(bytes);
    if (grown) bytes_ += bytes;
    return grown;
  }

 private:
  const std::shared_ptr<ReplyBudget::Share> share_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

struct ReplyBudget::Account {
  explicit Account(std::uint64_t bytes)
      : shares(bytes, "large requests and replies are being worked on") {}

  ClientShares shares;
  std::atomic<std::uint64_t> refused{0};
};

ReplyBudget::Share::Share(std::shared_ptr<Account> account, std::string client)
    : account_(std::move(account)), client_(std::move(client)) {}

ReplyBudget::Share::~Share() { account_->shares.give_back(client_, bytes_); }

Result<void> ReplyBudget::Share::grow(std::uint64_t bytes) {
  if (bytes == 0) return {};
  const std::uint64_t budget = account_->shares.most();
  if (bytes_ + bytes > budget) {
    ++account_->refused;
    return fail_limit(ServiceCode::too_much_memory,
                      "this reply takes more memory than the server has for replies; ask for less, "
                      "or in a binary format",
                      budget, bytes_ + bytes);
  }
  if (auto taken = account_->shares.take(client_, bytes, bytes_); !taken) {
    ++account_->refused;
    return taken;
  }
  bytes_ += bytes;
  return {};
}

void ReplyBudget::Share::shrink(std::uint64_t bytes) {
  if (bytes >= bytes_) return;
  account_->shares.give_back(client_, bytes_ - bytes);
  bytes_ = bytes;
}

ReplyBudget::ReplyBudget(std::uint64_t bytes) : account_(std::make_shared<Account>(bytes)) {}

auto ReplyBudget::reserve(std::uint64_t bytes, const std::string& client)
    -> Result<std::shared_ptr<Share>> {
  // First the object, which may not get its memory; then the bytes, which it gives back.
  auto share = share_of_nothing(client);
  if (auto grown = share->grow(bytes); !grown) return fail(std::move(grown.error()));
  return share;
}

auto ReplyBudget::share_of_nothing(const std::string& client) -> std::shared_ptr<Share> {
  return std::make_shared<Share>(account_, client);
}

auto ReplyBudget::take_part(const std::shared_ptr<Share>& share, std::uint64_t bytes)
    -> Result<std::shared_ptr<const void>> {
  const auto part = std::make_shared<PartOfShare>(share);
  if (auto taken = part->take(bytes); !taken) return fail(std::move(taken.error()));
  return part;
}

void ReplyBudget::set_budget(std::uint64_t bytes) { account_->shares.set_most(bytes); }

ReplyBudget::Stats ReplyBudget::stats() const {
  return {account_->shares.total(), account_->shares.most(), account_->refused};
}

}  // namespace geodesic::server
