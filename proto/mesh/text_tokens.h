// Words and numbers of a text file, one after another, with the line they are on.
// Numbers are read to the last bit and without locales; nothing is copied.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

namespace geodesic::proto {

// The text of a file, from behind the byte order mark that some editors put before it.
[[nodiscard]] inline std::string_view text_of_file(std::span<const std::byte> bytes) {
  std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

class TextTokens {
 public:
  explicit TextTokens(std::string_view text) : rest_(text) {}

  // The next word, over the ends of lines; empty at the end of the text.
  std::string_view word() {
    while (!rest_.empty()) {
      if (const auto found = word_on_line(); !found.empty()) return found;
      next_line();
    }
    return {};
  }

  // The next word before the end of the line; empty at its end. A backslash before
  // the end of a line joins the next one to it.
  std::string_view word_on_line() {
    for (;;) {
      std::size_t begin = 0;
      while (begin < rest_.size() && is_blank(rest_[begin])) ++begin;
      rest_.remove_prefix(begin);
      std::size_t end = 0;
      while (end < rest_.size() && !is_blank(rest_[end]) && !is_line_end(rest_[end])) ++end;
      const std::string_view found = rest_.substr(0, end);
      rest_.remove_prefix(end);
      const bool is_joined = found == "\\" && !rest_.empty() && is_line_end(rest_[0]);
      if (!is_joined) return found;
      next_line();
    }
  }

  // What is left of the line, without blanks at its ends.
  std::string_view words_on_line() {
    std::string_view found = rest_.substr(0, rest_.find_first_of("\r\n"));
    rest_.remove_prefix(found.size());
    while (!found.empty() && is_blank(found.front())) found.remove_prefix(1);
    while (!found.empty() && is_blank(found.back())) found.remove_suffix(1);
    return found;
  }

  // Steps over what is left of the line. False at the end of the text.
  bool next_line() {
    const std::size_t end = rest_.find_first_of("\r\n");
    if (end == std::string_view::npos) {
      rest_ = {};
      return false;
    }
    const bool two = rest_[end] == '\r' && end + 1 < rest_.size() && rest_[end + 1] == '\n';
    rest_.remove_prefix(end + (two ? 2 : 1));
    ++line_;
    return !rest_.empty();
  }

  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] std::string line() const { return "line " + std::to_string(line_); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

  std::string_view rest_;
  std::uint64_t line_ = 1;
};

// Whether a number is less than one, but for its sign, as its digits say and whatever its exponent.
[[nodiscard]] inline bool is_below_one(std::string_view number) {
  const std::string_view digits = number.substr(0, number.find_first_of("eE"));
  const std::size_t first = digits.find_first_of("123456789");
  if (first == std::string_view::npos) return true;
  // The power of ten of the first digit that counts.
  const auto point = static_cast<std::int64_t>(std::min(digits.find('.'), digits.size()));
  const std::int64_t before_point = point - static_cast<std::int64_t>(first);
  const std::int64_t power = before_point > 0 ? before_point - 1 : before_point;
  if (digits.size() == number.size()) return power < 0;
  std::string_view said = number.substr(digits.size() + 1);
  if (said.starts_with('+')) said.remove_prefix(1);
  std::int64_t exponent = 0;
  const auto read = std::from_chars(said.data(), said.data() + said.size(), exponent);
  if (read.ec == std::errc::result_out_of_range) return said.starts_with('-');
  return exponent < -power;
}

// All of a word as a number that is finite, or nothing. A leading plus is allowed.
[[nodiscard]] inline std::optional<double> finite_of_word(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  double value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  // What is too small to be told from zero is zero; what is too large is a fault.
  if (error == std::errc::result_out_of_range && stop == end) {
    return is_below_one(word) ? std::optional(0.0) : std::nullopt;
  }
  if (error != std::errc() || stop != end || word.empty() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

// All of a word as a whole number, or nothing.
[[nodiscard]] inline std::optional<std::int64_t> whole_of_word(std::string_view word) {
  std::int64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end || word.empty()) return std::nullopt;
  return value;
}

// Text of a stranger's, fit for a message.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string plain(text.substr(0, 128));
  for (char& c : plain) {
    if (c < 0x20 || c > 0x7E) c = '?';
  }
  return plain;
}

}  // namespace geodesic::proto
