#include "proto/formats/decode_obj.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "proto/mesh/one_part.h"
#include "proto/mesh/polygon_soup.h"
#include "proto/mesh/text_tokens.h"

namespace geodesic::proto {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view text, const DecodeLimits& limits) : tokens_(text), soup_(limits) {}

  Result<DecodedMesh> run() {
    do {
      if (const auto read = line(tokens_.word_on_line()); !read) return fail(read.error());
    } while (tokens_.next_line());
    Findings findings = std::move(findings_);
    auto soup = std::move(soup_).triangulated(findings);
    if (!soup) return fail(std::move(soup.error()));
    DecodedMesh mesh = mesh_of_one_part(MeshFormat::obj, std::move(*soup), name_);
    mesh.findings = findings.done();
    mesh.materials = std::move(materials_);
    if (const auto& runs = mesh.materials.runs;
        runs.size() == 1 && runs[0].material != kNoMaterial) {
      mesh.parts[0].material = runs[0].material;
    }
    return mesh;
  }

 private:
  Result<void> line(std::string_view keyword) {
    if (keyword == "v") return vertex();
    if (keyword == "f" || keyword == "fo") return face();
    if (keyword == "o" && name_.empty()) {
      name_ = std::string(tokens_.word_on_line().substr(0, 128));
    } else if (keyword == "usemtl") {
      use_material(tokens_.words_on_line());
    } else if (keyword == "l" || keyword == "p") {
      findings_.add("points_or_lines", tokens_.line(), "draws points or lines, which are left out");
    } else if (keyword == "curv" || keyword == "curv2" || keyword == "surf") {
      findings_.add("curved_left_out", tokens_.line(),
                    "is a free-form curve or surface, which is left out");
    }
    return {};
  }

  [[nodiscard]] tl::unexpected<Error> invalid(const std::string& what) const {
    return fail(ErrorCode::mesh_invalid, tokens_.line() + ": " + what);
  }

  Result<void> vertex() {
    std::array<double, 3> xyz{};
    for (double& coordinate : xyz) {
      const auto value = finite_of_word(tokens_.word_on_line());
      if (!value) return invalid("a vertex has three coordinates that are finite numbers.");
      coordinate = *value;
    }
    return soup_.add_vertex({xyz[0], xyz[1], xyz[2]});
  }

  // Of the faces that follow. Names may have blanks in them, as programs write them.
  void use_material(std::string_view name) {
    material_ = kNoMaterial;
    if (name.empty()) return;
    if (const auto known = places_.find(name); known != places_.end()) {
      material_ = known->second;
      return;
    }
    // Those behind the first kMostMaterials are not told apart.
    material_ = static_cast<std::uint32_t>(places_.size());
    if (places_.size() == kMostMaterials) return;
    places_.emplace(name, material_);
    materials_.add_name(name);
  }

  Result<void> face() {
    corners_.clear();
    for (auto word = tokens_.word_on_line(); !word.empty() && word[0] != '#';
         word = tokens_.word_on_line()) {
      const auto index = whole_of_word(word.substr(0, word.find('/')));
      // From 1 on, or back from the last vertex so far.
      const auto count = static_cast<std::int64_t>(soup_.vertex_count());
      const std::int64_t vertex = !index ? -1 : *index < 0 ? count + *index : *index - 1;
      if (!index || *index == 0 || vertex < 0 || vertex > 0xFFFFFFFF) {
        return invalid("a corner of the face names no vertex: " + printable(word.substr(0, 32)) +
                       ".");
      }
      corners_.push_back(static_cast<std::uint32_t>(vertex));
    }
    if (corners_.size() < 3) {
      return invalid("the face has " + std::to_string(corners_.size()) + " corners.");
    }
    materials_.add_faces(corners_.size() - 2, material_);  // it becomes so many triangles
    return soup_.add_face(corners_);
  }

  TextTokens tokens_;
  PolygonSoup soup_;
  Findings findings_;
  std::string name_;
  std::vector<std::uint32_t> corners_;
  FaceMaterials materials_;
  std::uint32_t material_ = kNoMaterial;
  std::map<std::string_view, std::uint32_t> places_;  // of materials, by names in the text
};

}  // namespace

bool is_obj(std::span<const std::byte> bytes) {
  static constexpr std::string_view kKeywords[] = {"v", "vn", "vt", "vp",     "f",      "o",
                                                   "g", "s",  "l",  "mtllib", "usemtl", "p"};
  TextTokens tokens(text_of_file(bytes));
  do {
    const auto keyword = tokens.word_on_line();
    if (keyword.empty() || keyword[0] == '#') continue;
    if (std::ranges::count(kKeywords, keyword) == 0) return false;
    return keyword == "g" || keyword == "s" || !tokens.word_on_line().empty();
  } while (tokens.next_line());
  return false;
}

Result<DecodedMesh> decode_obj(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  return ObjReader(text_of_file(bytes), limits).run();
}

}  // namespace geodesic::proto
