// A decoder process that does what hostile files would have it do: the file says what.
// What it does not know, it decodes.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <string_view>
#include <vector>

#include "server/decoder/process.h"

namespace {

using namespace geodesic;
using namespace geodesic::server;

// Leaves a frame that is all hole. Which of the open files it is, it does not know; the
// others are sockets and the mesh file.
[[noreturn]] void leave_hole() {
  constexpr std::uint64_t kSize = std::uint64_t{100} << 20U;
  for (int fd = 0; fd < 16; ++fd) (void)!::ftruncate(fd, kSize);
  for (int fd = 0; fd < 16; ++fd) (void)!::write(fd, &kSize, sizeof(kSize));
  ::_exit(0);
}

// With a name that says so, it is one that cannot make copies of itself. False if that
// cannot be had here.
bool is_as_named(std::string_view name) {
  if (!name.ends_with("without-fork")) return true;
  constexpr rlimit kOne{1, 1};
  constexpr uid_t kNobodyElse = 64321;  // the limit does not hold for root
  return ::setrlimit(RLIMIT_NPROC, &kOne) == 0 && (::getuid() != 0 || ::setuid(kNobodyElse) == 0);
}

Decoded rogue(std::span<const std::byte> bytes, const proto::DecodeLimits& limits,
              const proto::ImportOptions& options) {
  const std::string_view wish(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (wish == "crash") (void)::raise(SIGSEGV);
  if (wish == "end") ::_exit(0);
  if (wish == "hole") leave_hole();
  if (wish == "hang") {
    for (volatile int forever = 1; forever != 0;) {
    }
  }
  if (wish == "balloon") {
    std::vector<std::vector<char>> all;
    while (true) all.emplace_back(std::size_t{1} << 20U, 'x');
  }
  int did = -1;
  if (wish == "open") did = ::open("/etc/passwd", O_RDONLY);
  if (wish == "connect") did = ::socket(AF_INET, SOCK_STREAM, 0);
  if (wish == "fork") did = ::fork();
  if (wish == "run") did = ::execl("/bin/true", "true", nullptr);
  if (wish == "kill") did = ::kill(::getppid(), 0);
  if (wish == "code") {
    void* code = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC,
                        MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    did = code == MAP_FAILED ? -1 : 0;
  }
  if (did >= 0) return fail(ErrorCode::internal, "nothing kept me from it");
  return proto::decode_mesh(bytes, limits, options);
}

}  // namespace

int main(int /*argc*/, char** argv) {
  return is_as_named(argv[0]) ? run_decoder_process(rogue) : 1;
}
