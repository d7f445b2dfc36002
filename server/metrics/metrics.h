// What Prometheus scrapes: counts and times of requests and of the work behind
// them. Every label comes from a closed set (route patterns, HTTP methods, status
// codes, geodesic methods), so that no client can make series.
//
// Times are observed as they happen; sizes and counts that others keep (caches,
// pool, store, process) are read when asked for. Thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "server/metrics/present_state.h"

namespace geodesic::server {

class Metrics {
 public:
  using Present = PresentState;

  // `version` is told as a label of geodesicd_build_info.
  explicit Metrics(std::string_view version);
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // `route` empty: no route of ours.
  void request(std::string_view method, std::string_view route, int status, double seconds,
               std::uint64_t bytes_in, std::uint64_t bytes_out);
  // A field was computed, by a geodesic method.
  void solved(std::string_view method, double seconds);
  // A job of the compute pool waited this long for its slot.
  void queued(double seconds);
  // A step in making a mesh usable: "map", "read", "decode", "prepare", "index".
  void mesh_step(std::string_view step, double seconds);

  // Prometheus's text format, version 0.0.4.
  [[nodiscard]] std::string text(const Present& present);

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace geodesic::server
