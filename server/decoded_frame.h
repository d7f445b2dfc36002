// What goes between the server and a process that decodes for it: the order, and the
// decoded mesh or the error, as flat bytes. Both ends are the same program on the same
// machine, so numbers are as they are in memory; but whoever reads a frame takes none of
// it on trust.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/cancel.h"
#include "core/error.h"
#include "proto/decode_mesh.h"
#include "proto/import_options.h"

namespace geodesic::server {

struct DecodeOrder {
  proto::DecodeLimits limits;
  proto::ImportOptions options;
  std::uint64_t file_bytes = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t cpu_seconds = 0;
};

[[nodiscard]] std::string write_order(const DecodeOrder& order);
[[nodiscard]] std::optional<DecodeOrder> read_order(std::string_view bytes);

using Decoded = Result<proto::DecodedMesh>;

[[nodiscard]] std::size_t frame_size(const Decoded& decoded);
// `frame` has just that size.
void write_frame(const Decoded& decoded, std::span<std::byte> frame);
// Nothing if the bytes are no frame. Otherwise counts and names are those of the frame,
// which may lie: what they mean is for whoever uses them to check, as with a file's own.
// Nothing as well once `cancel` says so.
[[nodiscard]] std::optional<Decoded> read_frame(std::span<const std::byte> frame,
                                                const Cancel& cancel = {});

}  // namespace geodesic::server
