#include "server/edge/body.h"

#include <algorithm>
#include <charconv>

#include "server/http/head.h"

namespace geodesic::server {

namespace {

// A chunk's line is a number; extensions, which nobody uses, are skipped. More
// than this of either, or of trailers, is an attempt to keep us busy.
constexpr std::size_t kMaxLine = 256;
constexpr std::size_t kMaxTrailers = 4096;

}  // namespace

void HttpBody::take_data(std::string_view& arrived, std::string& body) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(arrived.size(), left_));
  if (body.size() + size > body.capacity()) {
    // What was announced, but not much more than what came: a promise costs nothing.
    const std::uint64_t announced = is_chunked_ ? limit_ : body.size() + left_;
    const std::uint64_t grown = std::max<std::uint64_t>(std::uint64_t{1} << 16, 4 * body.size());
    body.reserve(static_cast<std::size_t>(std::min(announced, grown)));
  }
  body.append(arrived.substr(0, size));
  arrived.remove_prefix(size);
  left_ -= size;
}

bool HttpBody::take_line(std::string_view& arrived, bool& malformed) {
  const std::size_t end = arrived.find('\n');
  const std::string_view part = arrived.substr(0, end);
  if (line_.size() + part.size() > kMaxLine) {
    malformed = true;
    return false;
  }
  line_ += part;
  if (end == std::string_view::npos) {
    arrived = {};
    return false;
  }
  arrived.remove_prefix(end + 1);
  // Lines end in CR LF; a CR or another control elsewhere is somebody's trick.
  malformed = line_.empty() || line_.back() != '\r' ||
              std::any_of(line_.begin(), line_.end() - 1, is_control);
  if (!malformed) line_.pop_back();
  return !malformed;
}

HttpBody::State HttpBody::begin_chunk(std::uint64_t had) {
  const char* const end = line_.data() + line_.size();
  std::uint64_t size = 0;
  const auto [stop, error] = std::from_chars(line_.data(), end, size, 16);
  const bool all_read = stop == end || *stop == ';';
  if (error == std::errc::result_out_of_range && all_read) return State::too_large;
  if (error != std::errc() || !all_read) return State::malformed;
  line_.clear();
  if (size == 0) {
    part_ = Part::trailer;
  } else if (size > limit_ - had) {
    return State::too_large;
  } else {
    part_ = Part::data;
    left_ = size;
  }
  return State::more;
}

HttpBody::State HttpBody::take(std::string_view& arrived, std::string& body) {
  bool malformed = false;
  while (true) {
    switch (part_) {
      case Part::data:
        take_data(arrived, body);
        if (left_ != 0) return State::more;
        if (!is_chunked_) return State::complete;
        part_ = Part::data_end;
        break;
      case Part::data_end:
        if (!take_line(arrived, malformed)) return malformed ? State::malformed : State::more;
        if (!line_.empty()) return State::malformed;
        part_ = Part::size_line;
        break;
      case Part::size_line:
        if (!take_line(arrived, malformed)) return malformed ? State::malformed : State::more;
        if (const State begun = begin_chunk(body.size()); begun != State::more) return begun;
        break;
      case Part::trailer:
        if (!take_line(arrived, malformed)) return malformed ? State::malformed : State::more;
        if (line_.empty()) return State::complete;
        // As strict as with headers: folded lines start with no name.
        if (!is_token(std::string_view(line_).substr(0, line_.find(':'))) ||
            line_.find(':') == std::string::npos) {
          return State::malformed;
        }
        trailer_bytes_ += line_.size();
        if (trailer_bytes_ > kMaxTrailers) return State::malformed;
        line_.clear();
        break;
    }
  }
}

}  // namespace geodesic::server
