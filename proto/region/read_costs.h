// Costs out of the parameters of a query.
#pragma once

#include "core/base/error.h"
#include "proto/region/costs.h"
#include "proto/wire/parameters.h"

namespace geodesic::proto {

// `weights`, `face_weights`, `weight_attribute`, `slope`, `steepest` and `up`. Errors: bad_syntax,
// value_out_of_range, unknown_parameter, and too_large (over one of query_limits.h), naming the one
// at fault such as "weights[2].region.sphere.radius".
[[nodiscard]] Result<Costs> read_costs(Parameters& parameters);

}  // namespace geodesic::proto
