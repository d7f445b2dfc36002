// The one table of the options that a configuration has. Flags, variables, the keys of the file,
// the help and the README's table are read from it, and values are set and written through it.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "core/base/error.h"
#include "server/config/config.h"

namespace geodesic::server {

struct Option {
  enum class Kind {
    text,
    whole_number,
    bytes,
    address,
    level,
    when_full,
    decoder,
    base_path,
    addresses,
    forwarded_header,
    proxy_protocol
  };
  using Member = std::variant<std::string Config::*, std::uint64_t Config::*, Address Config::*>;

  std::string_view name;  // of the flag, without dashes; file keys are the same
  Kind kind;
  Member member;
  std::string_view value_hint;
  std::string_view help;
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  bool follows = false;  // a running process takes a new value over when it reloads
};

// Defaults are those of `Config`.
[[nodiscard]] std::span<const Option> options();

// GEODESICD_… of an option's name.
[[nodiscard]] std::string variable_name(std::string_view option);

// An option's value as one would write it.
[[nodiscard]] std::string format_value(const Option& option, const Config& config);

// Sets one option; `source` opens the error's sentence. Errors: bad_syntax.
[[nodiscard]] Result<void> set_option(const Option& option, std::string_view text,
                                      std::string_view source, Config& config);

}  // namespace geodesic::server
