// Regions as clients ask for them, read from the body of a request.
#pragma once

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "proto/region/read_regions.h"
#include "proto/region/region.h"
#include "proto/wire/parameters.h"

namespace geodesic::proto {

inline Result<Regions> regions_of(const std::string& body) {
  auto parameters = Parameters::from_json(body);
  REQUIRE(parameters);
  return read_regions(*parameters);
}

inline Result<Regions> forbid(const nlohmann::json& region) {
  return regions_of(nlohmann::json{{"forbid", region}}.dump());
}

}  // namespace geodesic::proto
