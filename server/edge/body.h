// Takes a request's body out of the bytes of a connection as they come: counted,
// or in chunks (RFC 9112, 7.1). Strict, like http/head.h: where a body ends is
// where the next request begins, so a chunk that could be read in two ways ends
// the connection. Never holds more than the limit, whatever a client promises.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace geodesic::server {

class HttpBody {
 public:
  // Of exactly `size` bytes, which must be within the limit already …
  static HttpBody counted(std::uint64_t size) { return {Part::data, size, size}; }
  // … or in chunks, of at most `limit` bytes together.
  static HttpBody chunked(std::uint64_t limit) { return {Part::size_line, 0, limit}; }

  enum class State : std::uint8_t {
    more,       // all of `arrived` was taken, and more must come
    complete,   // what is left of `arrived` is not the body's
    too_large,  // over the limit, by what came or by what a chunk announced
    malformed,  // no chunks
  };
  // Moves bytes from the front of `arrived` to the end of `body`. After anything
  // but `more`, not to be called again.
  [[nodiscard]] State take(std::string_view& arrived, std::string& body);

 private:
  enum class Part : std::uint8_t { size_line, data, data_end, trailer };
  HttpBody(Part part, std::uint64_t left, std::uint64_t limit)
      : part_(part), is_chunked_(part != Part::data), left_(left), limit_(limit) {}

  void take_data(std::string_view& arrived, std::string& body);
  // Whether a line is complete in `line_`, without its end.
  bool take_line(std::string_view& arrived, bool& malformed);
  [[nodiscard]] State begin_chunk(std::uint64_t had);

  Part part_;
  bool is_chunked_;
  std::uint64_t left_;  // bytes of the body, or of the chunk, still to come
  std::uint64_t limit_;
  std::string line_;
  std::size_t trailer_bytes_ = 0;
};

}  // namespace geodesic::server
