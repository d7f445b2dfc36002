#include "tests/fuzz/targets.h"

#include <array>

namespace geodesic::fuzz {

std::span<const Target> targets() {
  static const std::array all{
      Target{"gltf", fuzz_decoding, gltf_seeds},
      Target{"draco", fuzz_decoding, draco_seeds},
      Target{"polygons", fuzz_decoding, polygon_seeds},
      Target{"mesh", fuzz_mesh, mesh_seeds},
      Target{"requests", fuzz_requests, request_seeds},
      Target{"points", fuzz_points, point_seeds},
      Target{"frame", fuzz_frame, frame_seeds},
      Target{"methods", fuzz_methods, mesh_seeds},
      Target{"heaps", fuzz_heaps, heap_seeds},
      Target{"lines", fuzz_lines, line_seeds},
      Target{"walls", fuzz_walls, wall_seeds},
      Target{"costs", fuzz_costs, cost_seeds},
      Target{"measures", fuzz_measures, mesh_seeds},
      Target{"head", fuzz_head, head_seeds},
      Target{"body", fuzz_body, body_seeds},
      Target{"form", fuzz_form, form_seeds},
      Target{"proxy_header", fuzz_proxy_header, proxy_header_seeds},
      Target{"forwarded", fuzz_forwarded, forwarded_seeds},
  };
  return all;
}

}  // namespace geodesic::fuzz
