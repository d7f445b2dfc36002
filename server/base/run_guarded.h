// What a computation throws, as an error that says nothing of its insides.
#pragma once

#include <spdlog/spdlog.h>

#include <exception>
#include <new>

#include "core/base/error.h"
#include "server/base/service_codes.h"

namespace geodesic::server {

// Runs `body()`. Errors: overloaded (out of memory), internal.
template <class Body>
[[nodiscard]] Result<void> run_guarded(Body&& body) {
  try {
    body();
    return {};
  } catch (const std::bad_alloc&) {
    // Memory is a resource like a free slot: the same job may do well later.
    spdlog::error("a job ran out of memory");
    return fail(ServiceCode::overloaded, "out of memory");
  } catch (const std::exception& thrown) {
    spdlog::error("a job threw: {}", thrown.what());
  } catch (...) {
    spdlog::error("a job threw something that is no exception");
  }
  return fail(ErrorCode::internal, "internal error");
}

}  // namespace geodesic::server
