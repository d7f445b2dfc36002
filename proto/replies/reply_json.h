// What the JSON of several replies is made of. Each appends to a text; written by hand, for a field
// of a million values as a JSON tree would take twenty times its memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/vec3.h"
#include "proto/replies/replies.h"
#include "proto/wire/number.h"

namespace geodesic::proto {

// Here and below, what is cut short by the poll is no JSON.
[[nodiscard]] inline bool is_stopped(Poll* poll) { return poll != nullptr && poll->cancelled(); }

template <class Values>
void append_numbers(std::string& out, const Values& values, int digits, Poll* poll = nullptr) {
  out += '[';
  bool first = true;
  for (const double value : values) {
    if (is_stopped(poll)) break;
    if (!first) out += ',';
    first = false;
    append_number(out, value, digits);
  }
  out += ']';
}

// After another member.
void append_member(std::string& out, const char* name, double value, int digits = 0);
void append_distances(std::string& out, std::span<const double> distances, int digits,
                      bool short_digits, Bound bound, Poll* poll);
// kNone as null.
void append_wholes(std::string& out, std::span<const std::uint32_t> values, Poll* poll);
void append_xyz(std::string& out, Vec3 p, int digits);
void append_whole(std::string& out, const std::optional<std::uint64_t>& value);
void append_point(std::string& out, const ResolvedPoint& point, int digits);
void append_points(std::string& out, const std::vector<ResolvedPoint>& points, int digits,
                   Poll* poll);
void append_path_points(std::string& out, const std::vector<PathReplyPoint>& points, int digits,
                        Poll* poll);
// Of a line on the surface, after another member.
void append_line(std::string& out, bool closed, double length, const std::vector<Vec3>& points,
                 int digits, Poll* poll);
// Mesh ids are hexadecimal and method names are ours: neither needs escaping.
[[nodiscard]] std::string opening(const std::string& mesh);
// The sentences are ours, and need no escaping.
void append_warnings(std::string& out, const Warnings& warnings);
void append_method(std::string& out, Method method);
// In what costs are, where distances are costs.
void append_unit(std::string& out, std::optional<std::string_view> unit);

}  // namespace geodesic::proto
