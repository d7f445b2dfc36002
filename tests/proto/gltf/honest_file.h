// A measure for how soon a file is refused, on any machine.
#pragma once

#include <doctest/doctest.h>

#include "core/mesh/shapes.h"
#include "tests/bench/processor_time.h"
#include "tests/proto/formats/polygon_files.h"
#include "tests/proto/gltf_file/fixture.h"

namespace geodesic::proto {

// The processor's time that 16 MB which claim no more than they have take, in milliseconds.
inline double ms_of_honest_file() {
  const Bytes bytes = bytes_of(stl_binary_of(shapes::icosphere(7)));
  return bench::processor_ms_of([&] { CHECK(decode(bytes).has_value()); });
}

}  // namespace geodesic::proto
