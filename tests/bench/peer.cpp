#include "tests/bench/peer.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <utility>

extern char** environ;

namespace geodesic::bench {
namespace {

// A solver that takes longer for one answer is given up.
constexpr std::chrono::seconds kPatience{120};

tl::unexpected<std::string> failure(std::string sentence) {
  return tl::unexpected<std::string>(std::move(sentence));
}

}  // namespace

tl::expected<Peer, Peer::Failure> Peer::start(const PeerSolver& solver,
                                              const std::filesystem::path& environments,
                                              const std::filesystem::path& mesh_folder,
                                              std::uint32_t source) {
  const std::string python = environments / solver.package / "bin" / "python";
  if (!std::filesystem::exists(python)) return failure("not installed");
  std::array<int, 2> to{};
  std::array<int, 2> from{};
  // Closed in children; posix_spawn's dup2 clears that for the two they get.
  if (pipe2(to.data(), O_CLOEXEC) != 0 || pipe2(from.data(), O_CLOEXEC) != 0) {
    return failure("no pipe");
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, to[0], 0);
  posix_spawn_file_actions_adddup2(&actions, from[1], 1);
  std::string words[] = {python, GEODESIC_PEER_WORKER, std::string(solver.name),
                         mesh_folder.string(), std::to_string(source)};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  Peer peer;
  const int error =
      posix_spawn(&peer.process_, python.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(to[0]);
  close(from[1]);
  peer.to_ = to[1];
  peer.from_ = from[0];
  if (error != 0) {
    peer.process_ = -1;
    return failure("cannot be started");
  }
  peer.mesh_folder_ = mesh_folder;
  auto line = peer.answer();
  if (!line) return failure(std::move(line.error()));
  std::string ready;
  std::istringstream(*line) >> ready >> peer.version_ >> peer.prepare_ms_;
  return peer;
}

Peer::Peer(Peer&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      to_(std::exchange(other.to_, -1)),
      from_(std::exchange(other.from_, -1)),
      unread_(std::move(other.unread_)),
      mesh_folder_(std::move(other.mesh_folder_)),
      version_(std::move(other.version_)),
      prepare_ms_(other.prepare_ms_) {}

Peer::~Peer() {
  if (to_ >= 0) close(to_);
  if (from_ >= 0) close(from_);
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

tl::expected<double, Peer::Failure> Peer::solve() {
  return ask("solve\n").map([](const std::string& line) { return std::atof(line.c_str()); });
}

tl::expected<std::vector<double>, Peer::Failure> Peer::distances() {
  auto saved = ask("save\n");
  if (!saved) return failure(std::move(saved.error()));
  const std::filesystem::path file = mesh_folder_ / "distance.f64";
  std::vector<double> values(std::filesystem::file_size(file) / sizeof(double));
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(double)));
  return values;
}

tl::expected<std::string, Peer::Failure> Peer::ask(std::string_view line) {
  // A worker that is gone shows when its answer is read.
  const ssize_t written = write(to_, line.data(), line.size());
  if (written != static_cast<ssize_t>(line.size())) return failure("it has ended");
  return answer();
}

tl::expected<std::string, Peer::Failure> Peer::answer() {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (unread_.find('\n') == std::string::npos) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        until - std::chrono::steady_clock::now());
    pollfd waiting{from_, POLLIN, 0};
    if (left.count() <= 0 || poll(&waiting, 1, static_cast<int>(left.count())) <= 0) {
      return failure("no answer in " + std::to_string(kPatience.count()) + " s");
    }
    std::array<char, 4096> bytes{};
    const ssize_t got = read(from_, bytes.data(), bytes.size());
    if (got <= 0) return failure("it crashed");
    unread_.append(bytes.data(), static_cast<std::size_t>(got));
  }
  const std::size_t end = unread_.find('\n');
  std::string line = unread_.substr(0, end);
  unread_.erase(0, end + 1);
  if (line.starts_with("failed ")) return failure(line.substr(7));
  return line;
}

}  // namespace geodesic::bench
