// Which of the file's materials each face has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace geodesic::proto {

// Of a file's materials, those that are kept by name and can be asked for: the first ones.
inline constexpr std::size_t kMostMaterials = 10'000;

// In place of a material, of faces that have none.
inline constexpr std::uint32_t kNoMaterial = 0xFFFFFFFF;

// Faces in a row that have one material; they begin where the run before ends.
struct MaterialRun {
  std::uint32_t end;       // the first face behind it
  std::uint32_t material;  // its place in the file, or kNoMaterial
};

// Faces behind the last run have no material.
struct FaceMaterials {
  std::vector<std::string> names;  // as told_name has them; "" where the file says none
  std::vector<MaterialRun> runs;   // in the order of faces, no two of one material in a row

  // Keeps a name, unless there are kMostMaterials.
  void add_name(std::string_view name);
  // The next faces, if there are any.
  void add_faces(std::uint64_t count, std::uint32_t material);
  // How many faces each of `names` has.
  [[nodiscard]] std::vector<std::uint64_t> face_counts() const;
  // Of the file's materials, how many there are at least: one more than the last place of a face.
  [[nodiscard]] std::uint64_t least_total() const;
  // How many faces have a material that is none of the first `listed`.
  [[nodiscard]] std::uint64_t faces_beyond(std::size_t listed) const;
  [[nodiscard]] std::size_t bytes() const;
};

}  // namespace geodesic::proto
