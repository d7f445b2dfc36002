// The memory of large replies, from before they are made until they are sent: asked for first,
// so that many at once are refused and do not fill the memory, and no client holds all of it. What
// a query starts from counts here, too (Caller::reserve). Small ones are not counted.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/error.h"

namespace geodesic::server {

// All methods may be called from any thread.
class ReplyBudget {
 private:
  struct Account;

 public:
  // One reply's reservation, held until this is destroyed. It may outlive the budget. One thread
  // at a time changes it.
  class Share {
   public:
    Share(std::shared_ptr<Account> account, std::string client);  // of 0 bytes
    ~Share();
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    // Takes so many bytes besides, as if all were asked for at once. Errors: those of `reserve`,
    // and nothing is taken.
    [[nodiscard]] Result<void> grow(std::uint64_t bytes);
    // Gives back all but `bytes`, once it is known what the reply takes.
    void shrink(std::uint64_t bytes);
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

   private:
    friend class ReplyBudget;
    const std::shared_ptr<Account> account_;
    const std::string client_;
    std::uint64_t bytes_ = 0;
  };

  struct Stats {
    std::uint64_t bytes = 0;    // reserved now
    std::uint64_t budget = 0;   // the most that may be
    std::uint64_t refused = 0;  // replies, since the start
  };

  explicit ReplyBudget(std::uint64_t bytes);

  // Errors: too_much_memory where there is not so much in all, so that nobody need try again;
  // overloaded where others have it now; too_many_requests where this client has its share
  // (client_shares.h).
  [[nodiscard]] Result<std::shared_ptr<Share>> reserve(std::uint64_t bytes,
                                                       const std::string& client);
  // For a reply that asks for its memory in steps.
  [[nodiscard]] std::shared_ptr<Share> share_of_nothing(const std::string& client);
  // So many bytes more of a share, until what is returned is gone. Errors: those of Share::grow.
  [[nodiscard]] static Result<std::shared_ptr<const void>> take_part(
      const std::shared_ptr<Share>& share, std::uint64_t bytes);

  // For replies to come.
  void set_budget(std::uint64_t bytes);
  [[nodiscard]] Stats stats() const;

 private:
  const std::shared_ptr<Account> account_;
};

}  // namespace geodesic::server
