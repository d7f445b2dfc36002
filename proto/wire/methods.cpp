#include "proto/wire/methods.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/wire/input_codes.h"

namespace geodesic::proto {

namespace {

std::vector<MethodParameter> steiner_parameters() {
  const MethodOptions standard;
  return {
      {"points_per_edge", true, 1, 64, static_cast<double>(standard.points_per_edge), Serves::all,
       "points added inside each edge, evenly spaced",
       [](MethodOptions& options, double value) {
         options.points_per_edge = static_cast<std::uint32_t>(value);
       },
       [](const MethodOptions& options) {
         return std::string(",").append(std::to_string(options.points_per_edge));
       }},
      {"tolerance", false, 1e-12, 1, standard.tolerance, Serves::paths,
       "a path is refined until a round shortens it by less than this part of its length",
       [](MethodOptions& options, double value) { options.tolerance = value; }, nullptr},
  };
}

std::string key_of_bound(const MethodOptions& options) {
  // Within a tolerance, distances are never below, whatever the bound.
  return options.bound == Bound::upper && !options.error_at_most ? ",upper" : "";
}

std::string key_of_error(const MethodOptions& options) {
  if (!options.error_at_most) return "";
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.begin(), digits.end(), *options.error_at_most);
  return std::string(",within ").append(digits.begin(), end.ptr);
}

std::vector<MethodParameter> back_traced_parameters() {
  return {
      {"bound",
       true,
       0,
       1,
       0,
       Serves::all,
       "upper: no distance is below the true one, each is the length of a path",
       [](MethodOptions& options, double value) {
         options.bound = value == 0 ? Bound::none : Bound::upper;
       },
       key_of_bound,
       {"none", "upper"}},
      {"tolerance", false, 0, 0.5, kNoStandard, Serves::distances,
       "no vertex's distance is above the true one by more than this part of it, nor below; 0 "
       "is exact. Without it there is no such promise",
       [](MethodOptions& options, double value) {
         options.error_at_most = value + 0.0;  // -0 becomes 0
       },
       key_of_error},
  };
}

}  // namespace

std::span<const MethodInfo> all_methods() {
  static const std::vector<MethodInfo> methods{
      {Method::back_traced, "auto",
       "For nearly all: as quick as a front, 0.01 % off on scans on average. `bound` and "
       "`tolerance` make it promises.",
       "Tang et al. 2007 on the intrinsic Delaunay triangulation (Bobenko, Springborn 2007), each "
       "vertex computed again by tracing its way back over ten faces. With a tolerance, that "
       "of `exact`, with vertices as further sources",
       false, "O(n log n)", back_traced_parameters()},
      {Method::wavefront,
       "wavefront",
       "The front of the paper, as quick as a Dijkstra along edges. On scans 0.1 to 0.5 % off on "
       "average.",
       "Jie Tang, Gang-Shan Wu, Fu-Yan Zhang, Ming-Min Zhang: Fast Approximate Geodesic Paths on "
       "Triangle Mesh. International Journal of Automation and Computing 4(1), 2007",
       false,
       "O(n log n)",
       {}},
      {Method::novotni,
       "novotni",
       "The rule that the paper improves on, for comparison. On scans 4 to 19 % off on average.",
       "Marcin Novotni, Reinhard Klein: Computing Geodesic Distances on Triangular Meshes. "
       "WSCG 2002",
       false,
       "O(n log n)",
       {}},
      {Method::fast_marching,
       "fast_marching",
       "The eikonal equation over triangles, for comparison. On scans 0.6 to 0.9 % off on average.",
       "Ron Kimmel, James A. Sethian: Computing Geodesic Paths on Manifolds. Proceedings of the "
       "National Academy of Sciences 95(15), 1998",
       false,
       "O(n log n)",
       {}},
      {Method::dijkstra,
       "dijkstra",
       "Ways along edges only, so never below the true distance. On scans 5 to 7 % off on average.",
       "Edsger W. Dijkstra: A Note on Two Problems in Connexion with Graphs. Numerische "
       "Mathematik 1, 1959. Along the edges only",
       false,
       "O(n log n)",
       {}},
      {Method::steiner, "steiner",
       "Ways over points added on edges, never below the true distance. On scans 0.7 to 0.9 % off "
       "on average.",
       "Takashi Kanai, Hiromasa Suzuki: Approximate Shortest Path on a Polyhedral Surface and Its "
       "Applications. Computer-Aided Design 33(11), 2001",
       false, "O(k n log(k n) + k^2 n) with k points on an edge", steiner_parameters()},
      {Method::exact,
       "exact",
       "The true distance on the mesh as it is, 20 to 30 times as slow as the default on scans, "
       "with much more memory.",
       "Joseph S. B. Mitchell, David M. Mount, Christos H. Papadimitriou: The Discrete Geodesic "
       "Problem. SIAM Journal on Computing 16(4), 1987. Vitaly Surazhsky, Tatiana Surazhsky, "
       "Danil Kirsanov, Steven J. Gortler, Hugues Hoppe: Fast Exact and Approximate Geodesics on "
       "Meshes. ACM Transactions on Graphics 24(3), 2005",
       true,
       "O(n^2 log n) at worst, about n^1.5 on scans",
       {}},
      {Method::chen_han,
       "chen_han",
       "The true distance by a second method, to check `exact` by. Some 5 times as slow as it.",
       "Jindong Chen, Yijie Han: Shortest Paths on a Polyhedron. International Journal of "
       "Computational Geometry and Applications 6(2), 1996. Shi-Qing Xin, Guo-Jin Wang: "
       "Improving Chen and Han's Algorithm on the Discrete Geodesic Problem. ACM Transactions on "
       "Graphics 28(4), 2009",
       true,
       "O(n^2 log n) at worst",
       {}},
  };
  return methods;
}

const MethodInfo& info_of(Method method) {
  const auto methods = all_methods();
  const auto it = std::find_if(methods.begin(), methods.end(),
                               [&](const MethodInfo& info) { return info.method == method; });
  return it == methods.end() ? methods.front() : *it;
}

Result<Method> find_method(std::string_view name) {
  std::string known;
  for (const MethodInfo& info : all_methods()) {
    if (info.name == name) return info.method;
    known += known.empty() ? "" : ", ";
    known += info.name;
  }
  return fail(InputCode::method_unknown, "no such method; there are: " + known, "method");
}

std::string field_key(const MethodChoice& choice) {
  const MethodInfo& info = info_of(choice.which);
  std::string key(info.name);
  for (const MethodParameter& parameter : info.parameters) {
    if (parameter.key != nullptr) key += parameter.key(choice.options);
  }
  return key;
}

std::string methods_json() {
  using nlohmann::ordered_json;
  const auto bound = [](const MethodParameter& parameter, double value) {
    return parameter.whole ? ordered_json(static_cast<std::uint64_t>(value)) : ordered_json(value);
  };
  const auto users_of = [](const MethodParameter& parameter) {
    return parameter.serves == Serves::all     ? "all"
           : parameter.serves == Serves::paths ? "paths"
                                               : "distances";
  };
  ordered_json methods = ordered_json::array();
  for (const MethodInfo& info : all_methods()) {
    ordered_json parameters = ordered_json::array();
    for (const MethodParameter& parameter : info.parameters) {
      if (!parameter.choices.empty()) {
        parameters.push_back({{"name", parameter.name},
                              {"type", "choice"},
                              {"choices", parameter.choices},
                              {"default", parameter.choices[std::size_t(parameter.standard)]},
                              {"for", users_of(parameter)},
                              {"meaning", parameter.meaning}});
        continue;
      }
      parameters.push_back({{"name", parameter.name},
                            {"type", parameter.whole ? "integer" : "number"},
                            {"minimum", bound(parameter, parameter.minimum)},
                            {"maximum", bound(parameter, parameter.maximum)},
                            {"default", bound(parameter, parameter.standard)},
                            {"for", users_of(parameter)},
                            {"meaning", parameter.meaning}});
    }
    methods.push_back({{"name", info.name},
                       {"default", info.method == kDefaultMethod},
                       {"about", info.about},
                       {"paper", info.paper},
                       {"exact", info.exact},
                       {"cost", info.cost},
                       {"parameters", std::move(parameters)}});
  }
  return ordered_json{{"methods", std::move(methods)}}.dump();
}

}  // namespace geodesic::proto
