// Decodes mesh files in processes of their own (decoder/process.h), which have no files,
// no network, and bounds on memory and time. Whatever a file does to its decoder, the
// server goes on, and the file's upload ends in an error.
//
// Thread-safe. As many decode at once as ask: that is bounded by the compute slots.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf/weights.h"
#include "proto/gltf_file/annotation.h"
#include "proto/mesh/decoded_mesh.h"
#include "server/base/caller.h"
#include "server/base/unique_fd.h"
#include "server/decoder/decoded_frame.h"

namespace geodesic::server {

class DecoderProcesses {
 public:
  struct Limits {
    // Of one decoder; for a small file less: half a GiB and 256 times its size.
    std::uint64_t memory_bytes = std::uint64_t{4} << 30;
    std::chrono::seconds time{60};
  };
  struct Stats {
    std::uint64_t running = 0;
    // Since the start, by how they ended.
    std::uint64_t decoded = 0;    // or found in its form, or to be annotated
    std::uint64_t refused = 0;    // the file has a fault
    std::uint64_t crashed = 0;    // the decoder ended without an answer
    std::uint64_t overtime = 0;   // it took too long
    std::uint64_t cancelled = 0;  // nobody wanted the answer any more
  };

  // `program` is one that asks `is_decoder_process`. Tries it out. Errors: internal, with
  // a sentence for the operator.
  [[nodiscard]] static Result<std::unique_ptr<DecoderProcesses>> start(std::string program,
                                                                       const Limits& limits);

  void set_limits(const Limits& limits);

  ~DecoderProcesses();
  DecoderProcesses(const DecoderProcesses&) = delete;
  DecoderProcesses& operator=(const DecoderProcesses&) = delete;

  // Does what proto::decode_mesh does, in a process of its own. Has these errors besides:
  // mesh_invalid if the process crashed or took too long, too_large if it needed too much memory,
  // overloaded if no process could be started, and what `caller` was stopped by, some 10 ms later.
  [[nodiscard]] Decoded decode(std::string_view bytes, const proto::DecodeLimits& limits,
                               const proto::ImportOptions& options, const Caller& caller);
  // Does what server::file_of_form does, with the same further errors.
  [[nodiscard]] Result<FormFile> file_of_form(std::string_view body, std::string_view boundary,
                                              const proto::DecodeLimits& limits,
                                              const Caller& caller);

  // Does what proto::annotate_gltf does, with the same further errors.
  [[nodiscard]] Result<proto::GltfAnnotation> annotation(
      std::string_view bytes, const std::vector<proto::VertexAttribute>& attributes,
      const proto::DecodeLimits& limits, const proto::ImportOptions& options, const Caller& caller);

  // Does what proto::read_face_numbers does, with the same further errors.
  [[nodiscard]] Result<proto::FaceNumbers> face_numbers(
      std::string_view bytes, const std::string& attribute, proto::FaceNumber which,
      const proto::DecodeLimits& limits, const proto::ImportOptions& options, const Caller& caller);

  [[nodiscard]] Stats stats() const;

 private:
  explicit DecoderProcesses(std::string program) : program_(std::move(program)) {}
  [[nodiscard]] bool start_process();
  void end_process();
  [[nodiscard]] bool process_is_there() const;
  [[nodiscard]] bool send(std::string_view order, int file, int frame, int reply);
  // `Content` as in decoded_frame.h.
  template <class Content>
  [[nodiscard]] Result<Content> answer(DecodeOrder order, std::string_view bytes,
                                       const Caller& caller);
  // Nothing if there is no answer.
  template <class Content>
  [[nodiscard]] std::optional<Result<Content>> wait(int reply, int frame, const Limits& limits,
                                                    const Caller& caller);
  [[nodiscard]] tl::unexpected<Error> given_up(const Caller& caller);
  [[nodiscard]] tl::unexpected<Error> too_long();
  [[nodiscard]] Limits limits() const;

  const std::string program_;
  mutable std::mutex mutex_;  // of the next three
  UniqueFd socket_;
  pid_t process_ = 0;  // 0: none
  Limits limits_;
  std::atomic<std::uint64_t> running_{0};
  std::atomic<std::uint64_t> decoded_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> crashed_{0};
  std::atomic<std::uint64_t> overtime_{0};
  std::atomic<std::uint64_t> cancelled_{0};
};

}  // namespace geodesic::server
