#include "proto/reply_format.h"

#include <algorithm>
#include <string_view>

namespace geodesic::proto {
namespace {

struct FormatName {
  Format format;
  std::string_view name;
  std::string_view media_type;
};

// In the order of preference among those that an Accept header admits.
constexpr FormatName kNames[] = {{Format::json, "json", "application/json"},
                                 {Format::f32, "f32", "application/octet-stream"},
                                 {Format::f64, "f64", "application/octet-stream"}};

bool contains(std::span<const Format> offered, Format format) {
  return std::find(offered.begin(), offered.end(), format) != offered.end();
}

// Whether one entry of an Accept header admits a media type. Quality values are
// read only as far as q=0, which forbids.
bool admits(std::string_view accept, std::string_view type) {
  const std::string_view family = type.substr(0, type.find('/'));
  while (!accept.empty()) {
    const std::size_t comma = accept.find(',');
    std::string_view entry = accept.substr(0, comma);
    accept = comma == std::string_view::npos ? "" : accept.substr(comma + 1);
    const std::size_t semicolon = entry.find(';');
    std::string_view parameters = semicolon == entry.npos ? "" : entry.substr(semicolon);
    entry = entry.substr(0, semicolon);
    const auto trim = [](std::string_view& text) {
      while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
      while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    };
    trim(entry);
    const bool named = entry == "*/*" || entry == type ||
                       (entry.ends_with("/*") && entry.substr(0, entry.size() - 2) == family);
    const bool forbidden = parameters.find("q=0") != parameters.npos &&
                           parameters.find_first_of("123456789") == parameters.npos;
    if (named && !forbidden) return true;
  }
  return false;
}

// The names, or the media types, of what is offered.
std::string list_of(std::span<const Format> offered, std::string_view FormatName::*column) {
  std::string list;
  for (const FormatName& row : kNames) {
    if (!contains(offered, row.format) || list.find(row.*column) != list.npos) continue;
    list += list.empty() ? "" : ", ";
    list += row.*column;
  }
  return list;
}

}  // namespace

Result<ReplyFormat> parse_format(Parameters& parameters, const std::string* accept,
                                 std::span<const Format> offered) {
  ReplyFormat reply;
  const auto precision = parameters.whole("precision");
  if (!precision) return fail(precision.error());
  if (*precision) {
    if (**precision < 1 || **precision > 17) {
      return fail(ErrorCode::value_out_of_range, "precision is a number of digits from 1 to 17",
                  "precision");
    }
    reply.precision = static_cast<int>(**precision);
  }
  const auto format = parameters.text("format");
  if (!format) return fail(format.error());
  if (!*format && (accept == nullptr || accept->empty())) return reply;
  for (const FormatName& row : kNames) {
    if (!contains(offered, row.format)) continue;
    if (*format ? **format == row.name : admits(*accept, row.media_type)) {
      reply.format = row.format;
      return reply;
    }
  }
  if (*format) {
    return fail(ErrorCode::not_acceptable,
                "this call has no such format; there are: " + list_of(offered, &FormatName::name),
                "format");
  }
  return fail(ErrorCode::not_acceptable,
              "offered are: " + list_of(offered, &FormatName::media_type), "Accept");
}

}  // namespace geodesic::proto
