// The parameters of a query, whether they came as a URL's query or as a JSON
// body: the same names, the same meaning.
//
// Each getter notes the name it was asked for; `check_all_known` then refuses
// whatever nobody asked for, so that a misspelt parameter is never ignored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/vec3.h"
#include "proto/wire/point_request.h"

namespace geodesic::proto {

class Parameters {
 public:
  // Decoded names and values, in order; a name may be repeated.
  [[nodiscard]] static Parameters from_query(
      const std::vector<std::pair<std::string, std::string>>& query);
  // An object. Errors: bad_syntax, with the byte at which it stops being JSON.
  [[nodiscard]] static Result<Parameters> from_json(std::string_view body);

  Parameters(Parameters&&) noexcept;
  Parameters& operator=(Parameters&&) noexcept;
  ~Parameters();

  // How many values there are under a name.
  [[nodiscard]] std::size_t count(std::string_view name) const;
  // All points under a name; in JSON one point or an array. Errors: bad_syntax,
  // value_out_of_range, naming the one at fault such as "from[2]".
  [[nodiscard]] Result<std::vector<PointRequest>> points(std::string_view name);
  // The same of what a field may start from.
  [[nodiscard]] Result<std::vector<PointRequest>> sources(std::string_view name);
  // Exactly one point.
  [[nodiscard]] Result<PointRequest> point(std::string_view name);
  [[nodiscard]] Result<PointRequest> source(std::string_view name);
  // At most one value. Errors: bad_syntax.
  [[nodiscard]] Result<std::optional<double>> number(std::string_view name);
  [[nodiscard]] Result<std::optional<std::uint64_t>> whole(std::string_view name);
  [[nodiscard]] Result<std::optional<std::string>> text(std::string_view name);
  // A number or a text as JSON text, to be repeated to the client. Errors: bad_syntax.
  [[nodiscard]] Result<std::optional<std::string>> scalar(std::string_view name);
  // 1 or 0, true or false; in JSON also `true` and `false`.
  [[nodiscard]] Result<std::optional<bool>> flag(std::string_view name);
  // All numbers under a name, such as levels=1&levels=2; in JSON one or an array.
  // Empty when there are none. Errors: bad_syntax, such as "levels[1]".
  [[nodiscard]] Result<std::vector<double>> numbers(std::string_view name);
  // Three numbers: direction=1,0,0, and in JSON the same text or [1,0,0].
  [[nodiscard]] Result<std::optional<Vec3>> vector(std::string_view name);

  // All values under a name, as they came, in an array; null when there are none.
  [[nodiscard]] const nlohmann::json* values(std::string_view name);

  // Errors: unknown_parameter.
  [[nodiscard]] Result<void> check_all_known() const;

 private:
  struct Values;
  explicit Parameters(std::unique_ptr<Values> values);
  std::unique_ptr<Values> values_;
};

}  // namespace geodesic::proto
