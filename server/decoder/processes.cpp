#include "server/decoder/processes.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <functional>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/decoder/local_message.h"
#include "server/decoder/process.h"

namespace geodesic::server {
namespace {

// How often a waiting thread asks whether anybody still wants the answer.
constexpr int kPatienceMilliseconds = 10;
constexpr int kLastMomentMilliseconds = 100;

// A file in memory, closed on exec.
UniqueFd memory_file(const char* name) {
  return UniqueFd(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
}

// Writes until all is written, or nobody waits for it any more. False if writing failed.
bool write_all(int fd, std::string_view bytes, const Caller& caller) {
  constexpr std::size_t kAtOnce = std::size_t{4} << 20;
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), std::min(bytes.size(), kAtOnce));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
    if (!bytes.empty() && caller()) break;
  }
  return true;
}

// Whether all of a file has been written to. Reading a hole would take memory that was never
// counted.
bool is_without_holes(const struct stat& about) {
  constexpr off_t kBlock = 512;  // stat's unit, whatever the file's own
  return about.st_blocks >= about.st_size / kBlock;
}

// What a decoder has left in its file. Nothing that it still does can take memory away
// under whoever reads here.
template <class Content>
std::optional<Result<Content>> frame_in(int fd, const Cancel& cancel) {
  struct stat about {};
  if (::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW) != 0 || ::fstat(fd, &about) != 0 ||
      about.st_size <= 0 || !is_without_holes(about)) {
    return std::nullopt;
  }
  const auto size = static_cast<std::size_t>(about.st_size);
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (data == MAP_FAILED) return std::nullopt;
  auto answer = read_frame<Content>({static_cast<const std::byte*>(data), size}, cancel);
  ::munmap(data, size);
  return answer;
}

tl::unexpected<Error> no_process() {
  return fail(ServiceCode::overloaded, "there is no process to decode the file");
}

bool says_no_copy(std::string_view answer) {
  return answer.size() == sizeof(kNoCopy) &&
         std::memcmp(answer.data(), &kNoCopy, sizeof(kNoCopy)) == 0;
}

std::uint64_t memory_for(std::size_t file_bytes, std::uint64_t most) {
  constexpr std::uint64_t kLeast = std::uint64_t{512} << 20;
  constexpr std::uint64_t kTimes = 256;
  return std::min(most, kLeast + kTimes * std::uint64_t{file_bytes});
}

struct Running {
  explicit Running(std::atomic<std::uint64_t>& count) : count_(count) { ++count_; }
  ~Running() { --count_; }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

 private:
  std::atomic<std::uint64_t>& count_;
};

}  // namespace

Result<std::unique_ptr<DecoderProcesses>> DecoderProcesses::start(std::string program,
                                                                  const Limits& limits) {
  std::unique_ptr<DecoderProcesses> processes(new DecoderProcesses(std::move(program)));
  processes->limits_ = limits;
  const Decoded tried = processes->decode("no mesh", {}, {}, {});
  if (tried.error().code != InputCode::format_unknown) {
    return fail(ErrorCode::internal, "mesh files cannot be decoded in processes of their own (" +
                                         tried.error().detail +
                                         "); --decoder in-process does without");
  }
  return processes;
}

DecoderProcesses::~DecoderProcesses() { end_process(); }

// Closes its socket, at which it ends. Under the lock.
void DecoderProcesses::end_process() {
  socket_.close();
  if (process_ > 0) ::waitpid(std::exchange(process_, 0), nullptr, 0);
}

// When a process ends, the sockets of its orders may be closed a moment before its own.
bool DecoderProcesses::process_is_there() const {
  UniqueFd socket;
  {
    const std::lock_guard lock(mutex_);
    socket = UniqueFd(::fcntl(socket_.get(), F_DUPFD_CLOEXEC, 0));
  }
  pollfd end{socket.get(), 0, 0};
  return socket && ::poll(&end, 1, kLastMomentMilliseconds) == 0;  // else its end is closed
}

void DecoderProcesses::set_limits(const Limits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

DecoderProcesses::Limits DecoderProcesses::limits() const {
  const std::lock_guard lock(mutex_);
  return limits_;
}

// With nothing of this process but one end of a new socket. Under the lock.
bool DecoderProcesses::start_process() {
  auto [ours, theirs] = local_pair();
  if (!ours) return false;
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, standard, "/dev/null", O_RDWR, 0);
  }
  posix_spawn_file_actions_adddup2(&files, theirs.get(), kDecoderSocket);
  posix_spawn_file_actions_addclosefrom_np(&files, kDecoderSocket + 1);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  std::string argument(kDecoderArgument);
  std::string name = program_;
  const std::array<char*, 3> arguments{name.data(), argument.data(), nullptr};
  const std::array<char*, 1> environment{nullptr};  // it has secrets
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program_.c_str(), &files, &attributes, arguments.data(),
                                  environment.data());
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    spdlog::error("no decoder process: {}", std::strerror(error));
    return false;
  }
  end_process();
  socket_ = std::move(ours);
  process_ = child;
  return true;
}

// To the process, or to another if that is no more.
bool DecoderProcesses::send(std::string_view order, int file, int frame, int reply) {
  const std::lock_guard lock(mutex_);
  if (socket_ && send_message(socket_.get(), order, {file, frame, reply})) return true;
  return start_process() && send_message(socket_.get(), order, {file, frame, reply});
}

Decoded DecoderProcesses::decode(std::string_view bytes, const proto::DecodeLimits& limits,
                                 const proto::ImportOptions& options, const Caller& caller) {
  return answer<proto::DecodedMesh>({{}, {}, {}, {}, limits, options}, bytes, caller);
}

Result<FormFile> DecoderProcesses::file_of_form(std::string_view body, std::string_view boundary,
                                                const proto::DecodeLimits& limits,
                                                const Caller& caller) {
  return answer<FormFile>({std::string(boundary), {}, {}, {}, limits, {}}, body, caller);
}

Result<proto::GltfAnnotation> DecoderProcesses::annotation(
    std::string_view bytes, const std::vector<proto::VertexAttribute>& attributes,
    const proto::DecodeLimits& limits, const proto::ImportOptions& options, const Caller& caller) {
  return answer<proto::GltfAnnotation>({{}, attributes, {}, {}, limits, options}, bytes, caller);
}

Result<proto::FaceNumbers> DecoderProcesses::face_numbers(
    std::string_view bytes, const std::string& attribute, proto::FaceNumber which,
    const proto::DecodeLimits& limits, const proto::ImportOptions& options, const Caller& caller) {
  return answer<proto::FaceNumbers>({{}, {}, attribute, which, limits, options}, bytes, caller);
}

template <class Content>
Result<Content> DecoderProcesses::answer(DecodeOrder order, std::string_view bytes,
                                         const Caller& caller) {
  const Running running(running_);
  const Limits own = this->limits();
  const UniqueFd file = memory_file("mesh");
  if (!file || !write_all(file.get(), bytes, caller)) return no_process();
  if (caller()) return given_up(caller);
  order.file_bytes = bytes.size();
  order.memory_bytes = memory_for(bytes.size(), own.memory_bytes);
  order.cpu_seconds = static_cast<std::uint64_t>(own.time.count()) + 1;
  // Twice if the process that makes the copies was killed meanwhile.
  for (int tries = 0; tries < 2; ++tries) {
    const UniqueFd frame = memory_file("decoded");
    auto [ours, theirs] = local_pair();
    if (!frame || !ours || !send(write_order(order), file.get(), frame.get(), theirs.get())) {
      return no_process();
    }
    theirs.close();  // so that its end is seen
    if (auto answer = wait<Content>(ours.get(), frame.get(), own, caller)) {
      return std::move(*answer);
    }
    if (process_is_there()) break;
  }
  ++crashed_;
  spdlog::warn("a decoder process ended without an answer");
  return fail(ErrorCode::mesh_invalid, "the decoder crashed on this file");
}

template <class Content>
std::optional<Result<Content>> DecoderProcesses::wait(int reply, int frame, const Limits& limits,
                                                      const Caller& caller) {
  const auto latest = Caller::Clock::now() + limits.time;
  while (true) {
    pollfd waiting{reply, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, kPatienceMilliseconds);
    if (ready > 0) break;
    if (caller()) return given_up(caller);
    if (Caller::Clock::now() >= latest) return too_long();
  }
  const auto answer = receive_message(reply, sizeof(std::uint64_t));
  if (answer && says_no_copy(answer->bytes)) {
    spdlog::error("no decoder process: the one that waits for files cannot fork");
    return no_process();
  }
  auto decoded = answer ? frame_in<Content>(frame, Cancel(std::cref(caller))) : std::nullopt;
  if (decoded) {
    ++(*decoded ? decoded_ : refused_);
  } else if (caller()) {
    return given_up(caller);
  } else if (Caller::Clock::now() >= latest) {
    return too_long();  // the kernel, which counts its seconds, was there first
  }
  return decoded;
}

tl::unexpected<Error> DecoderProcesses::too_long() {
  ++overtime_;
  spdlog::warn("a decoder process took too long");
  return fail(ErrorCode::mesh_invalid, "decoding the file takes too long");
}

tl::unexpected<Error> DecoderProcesses::given_up(const Caller& caller) {
  ++cancelled_;
  return fail(caller.why_stopped());
}

auto DecoderProcesses::stats() const -> Stats {
  return {running_, decoded_, refused_, crashed_, overtime_, cancelled_};
}

}  // namespace geodesic::server
