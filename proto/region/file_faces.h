// What a file calls its faces by, its parts and materials, and which of these a shape means.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/mesh/face_materials.h"
#include "proto/mesh/face_numbers.h"
#include "proto/mesh/metadata.h"
#include "proto/region/region.h"

namespace geodesic::proto {

// As far as shapes name it (NamedOfFile, region.h).
struct FileFaces {
  ToldParts parts;
  std::shared_ptr<const FaceMaterials> materials;  // null: none
  // By attribute, of each that a shape names.
  std::map<std::string, std::shared_ptr<const FaceNumbers>> labels;
};

// That no face has a label: value_out_of_range, whose message has the least that there are; or
// cancelled.
[[nodiscard]] tl::unexpected<Error> no_such_label(const std::vector<double>& by_face,
                                                  const LabelShape& shape, std::string parameter,
                                                  Poll& poll);

// The places of the parts that are meant, ascending. Errors, of `parameter`: index_out_of_range (a
// place that there is not), value_out_of_range (a name that no part has; the message has the
// nearest names), too_large (a name, where the file has more parts than kMostParts).
[[nodiscard]] Result<std::vector<std::size_t>> parts_meant(const FileFaces& file,
                                                           const PartShape& shape,
                                                           std::string parameter);

struct MeantMaterials {
  std::vector<std::uint8_t> by_place;  // not 0 for those that are meant
  bool none = false;                   // and faces that have none

  [[nodiscard]] bool has(std::uint32_t material) const {
    if (material == kNoMaterial) return none;
    return material < by_place.size() && by_place[material] != 0;
  }
};

// Errors, of `parameter`: index_out_of_range, value_out_of_range and too_large likewise (faces have
// materials behind the first kMostMaterials).
[[nodiscard]] Result<MeantMaterials> materials_meant(const FileFaces& file,
                                                     const MaterialShape& shape,
                                                     std::string parameter);

}  // namespace geodesic::proto
