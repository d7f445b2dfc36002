// The row of fields that are written back into the file that they are of.
#pragma once

#include "tests/bench/frontier_asked.h"

namespace geodesic::bench {

// Off by: the mean of a face's corners as the file has it, at the most, from that of the field.
// The time is that of the field, of reading the file and of writing it.
[[nodiscard]] Figures annotated_files(Asked& asked);

}  // namespace geodesic::bench
