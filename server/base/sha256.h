// SHA-256 of bytes, the address of a mesh.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace geodesic::server {

// Of bytes that come one piece after the other.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  void add(std::string_view bytes);
  // 64 lower-case hexadecimal digits; to be called once.
  [[nodiscard]] std::string hex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);
// The same, or nothing once `stop`, asked every few milliseconds, says so.
[[nodiscard]] std::optional<std::string> sha256_hex(std::string_view bytes,
                                                    const std::function<bool()>& stop);

}  // namespace geodesic::server
