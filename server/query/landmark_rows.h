// Rows of a table of which most entries are estimated, by the fields of some of its columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/landmarks/landmark_distances.h"
#include "proto/replies/replies.h"
#include "server/compute/pool.h"
#include "server/places/field_rows.h"
#include "server/query/fields.h"

namespace geodesic::server {

// The table that is asked for. Its rows are points.
struct PointTable {
  FieldQuestion question;  // without sources
  FieldRows from;
  std::vector<SurfacePoint> to;
  std::vector<std::uint32_t> faces;  // around those of `to`, if any is inside a face
};

class LandmarkRows {
 public:
  // What it takes, while it is made and later.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t landmarks, std::uint64_t rows,
                                           std::uint64_t columns);

  // Computes the fields of up to so many columns, in as many slots as are free, and of a few others
  // to learn by how much estimates are off, which goes to `estimated`. Which columns these are does
  // not depend on the rows. `fields` and `pool` must outlive it. Blocks. Errors: those of
  // Fields::row.
  [[nodiscard]] static Result<std::shared_ptr<const LandmarkRows>> make(
      Fields& fields, ComputePool& pool, std::shared_ptr<const PointTable> table,
      std::uint64_t landmarks, proto::Estimated& estimated, const Caller& caller);

  // As a part of ComputePool::run_each: what is near is computed, the rest estimated.
  [[nodiscard]] Result<std::vector<double>> row(std::size_t number, Worker& worker,
                                                const GiveWay& give_way,
                                                const Caller& caller) const;

 private:
  LandmarkRows(Fields& fields, std::shared_ptr<const PointTable> table, LandmarkDistances known)
      : fields_(fields), table_(std::move(table)), known_(std::move(known)) {}

  Fields& fields_;
  std::shared_ptr<const PointTable> table_;
  LandmarkDistances known_;
  std::vector<double> to_landmarks_;  // of each row, as many as there are landmarks
};

}  // namespace geodesic::server
