// One target as libFuzzer wants it; FUZZ_TARGET is its name.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace geodesic::fuzz;
  static const Target& target = []() -> const Target& {
    for (const Target& one : targets()) {
      if (one.name == FUZZ_TARGET) return one;
    }
    throw Broken("there is no such target");
  }();
  target.run({data, size});
  return 0;
}
