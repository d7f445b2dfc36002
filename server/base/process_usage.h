// What this process takes of the machine, as Linux tells it.
#pragma once

namespace geodesic::server {

struct ProcessUsage {
  double resident_bytes = 0;
  double virtual_bytes = 0;
  double cpu_seconds = 0;
  double open_fds = 0;
  double max_fds = 0;
};

[[nodiscard]] ProcessUsage process_usage();

}  // namespace geodesic::server
