#include "server/decoder/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/mesh/shapes.h"
#include "proto/encode/encode_mesh.h"
#include "proto/gltf/annotate.h"
#include "proto/gltf/weights.h"
#include "server/decoder/confine_process.h"
#include "server/decoder/decoded_frame.h"
#include "server/decoder/local_message.h"
#include "server/decoder/mesh_form.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kMostOrder = 65536;

std::string_view number_bytes(const std::uint64_t& number) {
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

// Memory of a file, until the process ends.
std::span<std::byte> mapped(int fd, std::size_t size, int protection, int flags) {
  void* data = ::mmap(nullptr, size, protection, flags, fd, 0);
  if (data == MAP_FAILED) return {};
  return {static_cast<std::byte*>(data), size};
}

tl::unexpected<Error> out_of_memory(const DecodeOrder& order) {
  Error error{
      ErrorCode::too_large, "decoding the file takes more memory than is allowed", {}, {}, {}};
  error.limit = order.memory_bytes;
  return tl::unexpected(std::move(error));
}

// False if there is no room for it.
template <class Content>
bool hand_over(const Result<Content>& answer, int frame_fd, int reply) {
  const std::uint64_t size = frame_size(answer);
  if (::ftruncate(frame_fd, static_cast<off_t>(size)) != 0) return false;
  const auto frame = mapped(frame_fd, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE);
  if (frame.empty()) return false;
  write_frame(answer, frame);
  return send_message(reply, number_bytes(size));
}

// What `find` makes of the file's bytes goes into the frame.
template <class Find>
void answer(const DecodeOrder& order, int file, int frame, int reply, const Find& find) {
  using Answer = std::invoke_result_t<Find, std::span<const std::byte>>;
  const auto bytes = mapped(file, order.file_bytes, PROT_READ, MAP_PRIVATE | MAP_POPULATE);
  Answer found = out_of_memory(order);
  try {
    if (!bytes.empty() || order.file_bytes == 0) found = find(bytes);
  } catch (const std::bad_alloc&) {
    // It says so already.
  }
  if (!hand_over(found, frame, reply)) (void)hand_over(Answer(out_of_memory(order)), frame, reply);
}

// Runs in the forked process. Once the server closes its end of the socket, because nobody waits
// any more or because it has ended, the kernel sends SIGIO. That ends this process.
void serve(const LocalMessage& message, Decode& decode, const Confinement& confinement) {
  const int file = message.fds[0].get();
  const int frame = message.fds[1].get();
  const int reply = message.fds[2].get();
  const auto order = read_order(message.bytes);
  if (!order || ::fcntl(reply, F_SETOWN, ::getpid()) != 0 ||
      ::fcntl(reply, F_SETFL, O_ASYNC) != 0) {
    return;
  }
  // The server may have closed its end before the signal was asked for.
  pollfd end{reply, POLLRDHUP, 0};
  if (::poll(&end, 1, 0) != 0) return;
  if (!confinement.enter({order->memory_bytes, order->cpu_seconds})) {
    const Decoded free = fail(ErrorCode::internal, "a decoder process cannot be confined here");
    (void)hand_over(free, frame, reply);
    return;
  }
  using Bytes = std::span<const std::byte>;
  if (!order->attributes.empty()) {
    answer(*order, file, frame, reply, [&](Bytes bytes) {
      return proto::annotate_gltf(bytes, order->limits, order->options, order->attributes);
    });
  } else if (!order->numbers.empty()) {
    answer(*order, file, frame, reply, [&](Bytes bytes) {
      return proto::read_face_numbers(bytes, order->limits, order->options, order->numbers,
                                      order->which);
    });
  } else if (order->boundary.empty()) {
    answer(*order, file, frame, reply,
           [&](Bytes bytes) { return decode(bytes, order->limits, order->options); });
  } else {
    answer(*order, file, frame, reply, [&](Bytes bytes) {
      const std::string_view body(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      return file_of_form(body, order->boundary, order->limits);
    });
  }
}

}  // namespace

bool is_decoder_process(int argc, const char* const* argv) {
  return argc == 2 && argv[1] == kDecoderArgument;
}

int run_decoder_process(Decode& decode) {
  // It ends with its server, not by a signal to all processes of a terminal.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_IGN);
  std::signal(SIGCHLD, SIG_IGN);  // nobody waits for the copies
  if (::chdir("/") != 0) return 1;
  // When memory runs out, better a decoder than the server.
  if (std::FILE* score = std::fopen("/proc/self/oom_score_adj", "w")) {
    std::fputs("1000", score);
    std::fclose(score);
  }
  const Confinement confinement;
  // What the first decoding does once is done once for all copies. These bytes are ours.
  const auto square = proto::encode_glb(shapes::plane(2, 2), "square");
  if (!proto::decode_mesh(square, {})) return 1;
  while (const auto message = receive_message(kDecoderSocket, kMostOrder)) {
    if (message->fds.size() != 3) continue;
    const pid_t copy = ::fork();
    if (copy < 0) (void)send_message(message->fds[2].get(), number_bytes(kNoCopy));
    if (copy != 0) continue;
    ::close(kDecoderSocket);
    serve(*message, decode, confinement);
    ::_exit(0);
  }
  return 0;
}

}  // namespace geodesic::server
