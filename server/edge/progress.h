// How far a step that never waits has come: reading, writing, a TLS handshake.
#pragma once

#include <cstdint>

namespace geodesic::server {

enum class Progress : std::uint8_t {
  done,         // as far as it was asked to
  wants_read,   // goes on when the socket is readable
  wants_write,  // goes on when the socket is writable
  closed,       // the peer has closed its end, or the connection failed
};

}  // namespace geodesic::server
