#include "proto/mesh/face_materials.h"

#include <algorithm>

#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {
namespace {

// Calls `visit` with each run's material and its number of faces.
template <class Visit>
void each_run(const std::vector<MaterialRun>& runs, Visit&& visit) {
  std::uint64_t begin = 0;
  for (const MaterialRun& run : runs) {
    if (run.end > begin) visit(run.material, run.end - begin);
    begin = run.end;
  }
}

}  // namespace

void FaceMaterials::add_name(std::string_view name) {
  if (names.size() == kMostMaterials) return;
  names.push_back(told_name(name));
}

void FaceMaterials::add_faces(std::uint64_t count, std::uint32_t material) {
  const std::uint64_t end = (runs.empty() ? 0 : runs.back().end) + count;
  if (count == 0 || end > kNoMaterial) return;  // no mesh of so many faces is built
  if (runs.empty() || runs.back().material != material) runs.push_back({0, material});
  runs.back().end = static_cast<std::uint32_t>(end);
}

std::vector<std::uint64_t> FaceMaterials::face_counts() const {
  std::vector<std::uint64_t> counts(names.size());
  each_run(runs, [&](std::uint32_t material, std::uint64_t faces) {
    if (material < counts.size()) counts[material] += faces;
  });
  return counts;
}

std::uint64_t FaceMaterials::least_total() const {
  std::uint64_t total = names.size();
  each_run(runs, [&](std::uint32_t material, std::uint64_t /*faces*/) {
    if (material != kNoMaterial) total = std::max(total, std::uint64_t{material} + 1);
  });
  return total;
}

std::uint64_t FaceMaterials::faces_beyond(std::size_t listed) const {
  std::uint64_t count = 0;
  each_run(runs, [&](std::uint32_t material, std::uint64_t faces) {
    if (material >= listed && material != kNoMaterial) count += faces;
  });
  return count;
}

std::size_t FaceMaterials::bytes() const {
  std::size_t count =
      sizeof *this + runs.capacity() * sizeof(MaterialRun) + names.capacity() * sizeof(std::string);
  for (const std::string& name : names) count += name.capacity();
  return count;
}

}  // namespace geodesic::proto
