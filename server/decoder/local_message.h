// Messages between processes of one machine over a pair of SOCK_SEQPACKET sockets,
// which may carry open files along.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/unique_fd.h"

namespace geodesic::server {

// Not more files than this in one message.
inline constexpr std::size_t kMostFds = 4;

struct LocalMessage {
  std::string bytes;
  std::vector<UniqueFd> fds;
};

// Two ends that are closed on exec; both -1 if there can be none.
[[nodiscard]] std::pair<UniqueFd, UniqueFd> local_pair();

// False if nobody is at the other end (any more).
[[nodiscard]] bool send_message(int socket, std::string_view bytes,
                                std::initializer_list<int> fds = {});

// Waits for the next; nothing once the other end is closed, or if the message was longer
// than `most` bytes.
[[nodiscard]] std::optional<LocalMessage> receive_message(int socket, std::size_t most);

}  // namespace geodesic::server
