// What can be wrong with a configuration besides its values: the files and places
// that it names. Reads them, and neither opens the store nor binds an address.
#pragma once

#include <string>
#include <vector>

#include "server/config/config.h"

namespace geodesic::server {

// A sentence for each problem: the tokens' file, the pair of certificate and key,
// the store's URL with its credentials. Empty: none was found.
[[nodiscard]] std::vector<std::string> problems_of(const Config& config,
                                                   const Environment& environment);

// What `--check-config` answers: the problems of `command` and of what it names, a
// line each; empty if the process could start with it.
[[nodiscard]] std::string check_config(const CommandLine& command, const Environment& environment);

}  // namespace geodesic::server
