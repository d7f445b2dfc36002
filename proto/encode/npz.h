// A sparse matrix as the file that SciPy's load_npz reads.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "proto/replies/replies.h"

namespace geodesic::proto {

// A .npz of `data` (float64), `indices` and `indptr` (int32), `shape` (rows, columns; int64) and
// `format` (csr): a zip file whose members are stored as they are, in this order, with no times.
// There are fewer than 2^31 entries, and the file is smaller than 4 GB.
[[nodiscard]] std::string npz(const SparseEntries& entries,
                              const std::array<std::uint64_t, 2>& shape);

}  // namespace geodesic::proto
