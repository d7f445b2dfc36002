// A prepared mesh as bytes, which are used where they lie: the arrays of Mesh and Adjacency one
// after another, behind a head that says which mesh they are of and which build of the engine has
// made them. A checksum (XXH3, 128 bits) in the head covers all bytes that follow it. It guards
// against what disks and crashes do, not against who may write the file.
//
// Numbers are as this machine has them, and records as this build lays them out: another build
// reads none of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/surface/adjacency.h"

namespace geodesic::server {

// Whose bytes they are.
struct PreparedName {
  std::string_view mesh;    // its id
  std::string_view engine;  // the digest of the build (server/routes/engine_digest.h)
};

// How many bytes it takes to write a mesh.
[[nodiscard]] std::uint64_t prepared_bytes(const Adjacency& adjacency);

// Writes one to a file that is open at its beginning. `stop` is asked every few milliseconds.
// Errors: cancelled, store_full, store_failed.
[[nodiscard]] Result<void> write_prepared(int file, const PreparedName& name,
                                          const Adjacency& adjacency,
                                          const std::function<bool()>& stop);

// The checksum of a prepared mesh's bytes, which come one piece after the other.
class PreparedChecksum {
 public:
  PreparedChecksum();
  ~PreparedChecksum();
  PreparedChecksum(const PreparedChecksum&) = delete;
  PreparedChecksum& operator=(const PreparedChecksum&) = delete;
  // `offset`: of the piece, in the whole.
  void add(std::uint64_t offset, std::span<const std::byte> piece);
  // As it is written.
  [[nodiscard]] std::array<std::byte, 16> value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The mesh that was written. Its arrays are the bytes themselves, which must begin at a multiple of
// 64 and are there as long as `holder` is. Null if the head names another mesh or build, if the
// size is wrong, or if `checksum`, computed over all bytes, is not the one in the head.
[[nodiscard]] std::shared_ptr<const Adjacency> read_prepared(
    std::span<const std::byte> bytes, const std::shared_ptr<const void>& holder,
    const PreparedName& name, const PreparedChecksum& checksum);

}  // namespace geodesic::server
