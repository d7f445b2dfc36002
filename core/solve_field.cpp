#include "core/solve_field.h"

#include "core/edge_dijkstra.h"
#include "core/novotni.h"

namespace geodesic {

Result<Field> solve_field(Method method, const MethodOptions& options, const Adjacency& adjacency,
                          std::span<const Source> sources, const FieldLimits& limits,
                          SolveScratch& scratch, const Cancel& cancel) {
  switch (method) {
    case Method::wavefront:
      return wavefront_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::novotni:
      return novotni_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::dijkstra:
      return edge_dijkstra_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::fast_marching:
    case Method::steiner:
    case Method::exact:
    case Method::chen_han:
      break;
  }
  (void)options;
  return fail(ErrorCode::internal, "a method without an implementation");
}

}  // namespace geodesic
