#include "proto/region/file_faces.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include "proto/mesh/text_tokens.h"
#include "proto/wire/cut_to.h"
#include "proto/wire/mesh_name.h"
#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

// Of names that are looked at for being near, and told of; and of the bytes of each in a message.
constexpr std::size_t kMostNamesCompared = 1'000;
constexpr std::size_t kMostNamesTold = 3;
constexpr std::size_t kMostBytesTold = 60;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// How many bytes are to be put in, taken out or changed to make one of the other (Levenshtein
// 1966), capitals being what small letters are. Both are as short as told_name makes them.
std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

// Names come from files and from strangers, and messages end on terminals.
std::string in_quotes(std::string_view name) {
  const std::string told = cut_to(name, kMostBytesTold);
  return '"' + (is_mesh_name(told) ? told : printable(told)) + '"';
}

// `what`: "part" or "material".
tl::unexpected<Error> no_such_name(const std::string& what, const std::string& name,
                                   const std::set<std::string_view>& names, std::string parameter) {
  std::string detail = "the mesh has no " + what + " " + in_quotes(name);
  std::vector<std::pair<std::size_t, std::string_view>> nearest;
  for (const std::string_view other : names) {
    if (nearest.size() == kMostNamesCompared) break;
    if (!other.empty()) nearest.emplace_back(edits_between(name, other), other);
  }
  if (nearest.empty()) {
    detail += "; its " + what + "s have no names, only numbers";
  } else {
    const std::size_t told = std::min(nearest.size(), kMostNamesTold);
    std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(told),
                      nearest.end());
    detail += told < nearest.size() ? "; the nearest names are " : "; it has ";
    for (std::size_t i = 0; i < told; ++i) {
      if (i > 0) detail += ", ";
      detail += in_quotes(nearest[i].second);
    }
  }
  return fail(ErrorCode::value_out_of_range, std::move(detail), std::move(parameter));
}

tl::unexpected<Error> no_such_place(const std::string& what, std::size_t count, std::uint64_t place,
                                    std::string parameter) {
  return fail_limit(
      ErrorCode::index_out_of_range,
      count == 0 ? "the mesh lists no " + what + "s" : "the mesh lists no such " + what,
      count == 0 ? 0 : count - 1, place, std::move(parameter));
}

// `known` is how many have names.
tl::unexpected<Error> not_all_of_a_name(const std::string& what, std::size_t known,
                                        std::uint64_t total, std::string parameter) {
  return fail_limit(ErrorCode::too_large,
                    "the mesh has more " + what +
                        "s than have numbers, so that not all of a name are known; say " + what +
                        "s by number, or faces",
                    known, total, std::move(parameter));
}

// The places of a name; `name_of(place)` is told of each of `count`.
template <class NameOf>
Result<std::vector<std::size_t>> places_of(const std::string& what, const std::string& name,
                                           std::size_t count, const NameOf& name_of,
                                           std::string parameter) {
  const std::string told = told_name(name);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < count; ++i) {
    if (name_of(i) == told) places.push_back(i);
  }
  if (!places.empty()) return places;
  if (count == 0) {
    return fail(ErrorCode::value_out_of_range, "the mesh has no " + what + "s",
                std::move(parameter));
  }
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < count && names.size() <= kMostNamesCompared; ++i) {
    names.insert(name_of(i));
  }
  return no_such_name(what, told, names, std::move(parameter));
}

std::uint64_t least_total_of(const FileFaces& file) {
  return file.materials != nullptr ? file.materials->least_total() : 0;
}

}  // namespace

tl::unexpected<Error> no_such_label(const std::vector<double>& by_face, const LabelShape& shape,
                                    std::string parameter, Poll& poll) {
  constexpr std::size_t kMostTold = 10;
  std::set<double> least;
  bool are_more = false;
  for (const double label : by_face) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (!std::isfinite(label)) continue;
    least.insert(label);
    if (least.size() <= kMostTold) continue;
    least.erase(std::prev(least.end()));
    are_more = true;
  }
  const auto number = [](double value) {
    std::string text;
    constexpr int kDigitsOfFloats = 9;
    append_number(text, value, LabelShape::is_compared_exactly(value) ? 0 : kDigitsOfFloats);
    return text;
  };
  std::string detail = "no face has " + number(shape.value) + " in " + in_quotes(shape.attribute) +
                       " at all corners";
  if (least.empty()) {
    detail += ", or any other number";
  } else {
    detail += are_more ? "; the least that there are: " : "; there are: ";
    for (const double label : least)
      detail += (label == *least.begin() ? "" : ", ") + number(label);
  }
  return fail(ErrorCode::value_out_of_range, std::move(detail), std::move(parameter));
}

Result<std::vector<std::size_t>> parts_meant(const FileFaces& file, const PartShape& shape,
                                             std::string parameter) {
  const std::vector<ToldPart>& parts = file.parts.parts;
  if (const auto* place = std::get_if<std::uint64_t>(&shape.part)) {
    if (*place < parts.size()) return std::vector<std::size_t>{*place};
    return no_such_place("part", parts.size(), *place, std::move(parameter));
  }
  if (parts.size() < file.parts.total) {
    return not_all_of_a_name("part", parts.size(), file.parts.total, std::move(parameter));
  }
  return places_of(
      "part", std::get<std::string>(shape.part), parts.size(),
      [&](std::size_t i) -> const std::string& { return parts[i].name; }, std::move(parameter));
}

Result<MeantMaterials> materials_meant(const FileFaces& file, const MaterialShape& shape,
                                       std::string parameter) {
  std::span<const std::string> names;
  if (file.materials != nullptr) names = file.materials->names;
  MeantMaterials meant;
  meant.by_place.resize(names.size());
  if (std::holds_alternative<NoMaterial>(shape.material)) {
    meant.none = true;
  } else if (const auto* place = std::get_if<std::uint64_t>(&shape.material)) {
    if (*place >= names.size()) {
      return no_such_place("material", names.size(), *place, std::move(parameter));
    }
    meant.by_place[*place] = 1;
  } else if (const std::uint64_t total = least_total_of(file); total > names.size()) {
    return not_all_of_a_name("material", names.size(), total, std::move(parameter));
  } else {
    const auto places = places_of(
        "material", std::get<std::string>(shape.material), names.size(),
        [&](std::size_t i) -> const std::string& { return names[i]; }, std::move(parameter));
    if (!places) return fail(places.error());
    for (const std::size_t one : *places) meant.by_place[one] = 1;
  }
  return meant;
}

}  // namespace geodesic::proto
