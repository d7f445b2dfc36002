// A number for each face of a file: a weight, or a label.
#pragma once

#include <vector>

namespace geodesic::proto {

struct FaceNumbers {
  std::vector<double> by_face;  // of the file, in the order of decoding
};

}  // namespace geodesic::proto
