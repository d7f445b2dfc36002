// Many fields of one mesh, in threads: the mesh is prepared once and shared, and each thread has a
// scratch of its own. Finds the vertex of a terrain from which the farthest one is nearest.
#include <geodesic/mesh/shapes.h>
#include <geodesic/solve/solve_field.h>

#include <cstdio>
#include <thread>
#include <vector>

using namespace geodesic;

int main() {
  auto mesh = std::make_shared<const Mesh>(*Mesh::build(shapes::terrain(60, 2, 1)));
  const Adjacency adjacency = Adjacency::build(mesh);
  std::vector<double> farthest(mesh->vertex_count());

  constexpr std::uint32_t kThreads = 4;
  const auto work = [&](std::uint32_t first) {
    SolveScratch scratch;
    FieldLimits limits;
    limits.keep_details = false;  // no paths are asked for
    for (std::uint32_t v = first; v < farthest.size(); v += kThreads) {
      const Source source{point_at_vertex(adjacency, v), 0};
      const auto field =
          solve_field(Method::back_traced, {}, adjacency, {&source, 1}, limits, scratch, Cancel());
      farthest[v] = field->max;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t i = 0; i < kThreads; ++i) threads.emplace_back(work, i);
  }

  std::uint32_t centre = 0;
  for (std::uint32_t v = 1; v < farthest.size(); ++v) {
    if (farthest[v] < farthest[centre]) centre = v;
  }
  std::printf("from vertex %u everything is within %.6f\n", mesh->source_of_vertex(centre),
              farthest[centre]);
}
