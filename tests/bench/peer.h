// A distance solver that is not ours, in a process of its own: peer_worker.py in the
// Python environment that scripts/fetch_peers made for it.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace geodesic::bench {

struct PeerSolver {
  std::string_view name;     // in peer_worker.py
  std::string_view package;  // on PyPI, and the folder of its environment
  std::string_view what;
};

inline constexpr std::array kPeerSolvers{
    PeerSolver{"potpourri3d_heat", "potpourri3d", "heat method"},
    PeerSolver{"potpourri3d_fast_marching", "potpourri3d", "fast marching"},
    PeerSolver{"libigl_heat", "libigl", "heat method"},
    PeerSolver{"libigl_exact", "libigl", "exact (MMP)"},
    PeerSolver{"pygeodesic_exact", "pygeodesic", "exact (MMP)"},
    PeerSolver{"gdist_exact", "gdist", "exact (MMP)"},
};

class Peer {
 public:
  // A sentence for people.
  using Failure = std::string;

  // `mesh_folder` holds positions.f64 and faces.u32; distances are from `source`.
  // Returns once the solver has prepared the mesh.
  [[nodiscard]] static tl::expected<Peer, Failure> start(const PeerSolver& solver,
                                                         const std::filesystem::path& environments,
                                                         const std::filesystem::path& mesh_folder,
                                                         std::uint32_t source);
  Peer(Peer&& other) noexcept;
  Peer& operator=(Peer&&) = delete;
  ~Peer();

  [[nodiscard]] const std::string& version() const { return version_; }
  [[nodiscard]] double prepare_ms() const { return prepare_ms_; }
  // One distance field, in milliseconds by its own clock.
  [[nodiscard]] tl::expected<double, Failure> solve();
  // The last field, one distance a vertex.
  [[nodiscard]] tl::expected<std::vector<double>, Failure> distances();

 private:
  Peer() = default;
  [[nodiscard]] tl::expected<std::string, Failure> ask(std::string_view line);
  [[nodiscard]] tl::expected<std::string, Failure> answer();

  pid_t process_ = -1;
  int to_ = -1;
  int from_ = -1;
  std::string unread_;
  std::filesystem::path mesh_folder_;
  std::string version_;
  double prepare_ms_ = 0;
};

}  // namespace geodesic::bench
