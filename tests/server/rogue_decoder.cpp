// A decoder process that does what hostile files would have it do: the file says what.
// What it does not know, it decodes.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <string_view>
#include <vector>

#include "server/decoder_process.h"

namespace {

using namespace geodesic;
using namespace geodesic::server;

Decoded rogue(std::span<const std::byte> bytes, const proto::DecodeLimits& limits,
              const proto::ImportOptions& options) {
  const std::string_view wish(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (wish == "crash") (void)::raise(SIGSEGV);
  if (wish == "end") ::_exit(0);
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

int main() { return run_decoder_process(rogue); }
