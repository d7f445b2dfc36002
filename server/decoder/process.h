// The process that decodes for a server: started with nothing but a socket, it makes a
// copy of itself for each order, and the copy decodes one file and ends. So no file can
// do anything to the decoding of another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "proto/formats/decode_mesh.h"
#include "server/decoder/decoded_frame.h"

namespace geodesic::server {

// The argument that a program starts with to be one, and where it then finds its socket.
inline constexpr std::string_view kDecoderArgument = "--decoder-process";
inline constexpr int kDecoderSocket = 3;
// Told in place of a frame's size when no copy could be made.
inline constexpr std::uint64_t kNoCopy = 0;

// Whether these are the arguments of a decoder process: to be asked before anything else
// in `main`, which then returns what `run_decoder_process` does.
[[nodiscard]] bool is_decoder_process(int argc, const char* const* argv);

using Decode = Decoded(std::span<const std::byte> bytes, const proto::DecodeLimits& limits,
                       const proto::ImportOptions& options);

// Serves orders until the other end of the socket is closed. An order (decoded_frame.h)
// comes with three files: the mesh file or form, an empty memory file for the frame, and a
// socket for one message, the frame's size in 8 bytes. Who closes that socket's other
// end kills the copy.
int run_decoder_process(Decode& decode = proto::decode_mesh);

}  // namespace geodesic::server
