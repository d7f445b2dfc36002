// The frame in which a decoder process hands its mesh over.
#include <cstring>
#include <string>
#include <vector>

#include "server/decoder/decoded_frame.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {

void fuzz_frame(Input input) {
  const auto bytes = std::as_bytes(input);
  (void)server::read_order({reinterpret_cast<const char*>(input.data()), input.size()});
  (void)server::read_frame<server::FormFile>(bytes);
  (void)server::read_frame<proto::GltfAnnotation>(bytes);
  const auto read = server::read_frame(bytes);
  if (!read) return;
  // What was taken for a frame is one: written anew it is the same, to the byte.
  std::vector<std::byte> again(server::frame_size(*read));
  server::write_frame(*read, again);
  expect(again.size() == bytes.size(), "a frame has one size");
  const auto twice = server::read_frame(again);
  expect(twice.has_value() && twice->has_value() == read->has_value(), "and one meaning");
}

}  // namespace geodesic::fuzz
