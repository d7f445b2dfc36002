// Distances from the first vertex of an OBJ file of triangles, and the path to the farthest one.
//
//     distances_and_a_path FILE.obj
#include <geodesic/solve/distances.h>
#include <geodesic/solve/pair_search.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

using namespace geodesic;

TriangleSoup read_obj(const char* name) {
  TriangleSoup soup;
  std::ifstream file(name);
  for (std::string word, a, b, c; file >> word;) {
    if ((word != "v" && word != "f") || !(file >> a >> b >> c)) continue;
    if (word == "v") soup.positions.push_back({std::stod(a), std::stod(b), std::stod(c)});
    const auto vertex = [](const std::string& s) { return std::uint32_t(std::stoul(s) - 1); };
    if (word == "f") soup.faces.push_back({vertex(a), vertex(b), vertex(c)});
  }
  return soup;
}

int main(int argc, char** argv) {
  const auto mesh = Mesh::build(read_obj(argc == 2 ? argv[1] : ""));
  if (!mesh) return std::fprintf(stderr, "%s\n", mesh.error().detail.c_str()), 1;
  const std::vector<double> from_first = *distances(*mesh, 0);  // in the order of the file
  const auto farthest = std::ranges::max_element(from_first) - from_first.begin();
  std::printf("vertex %d is %.9f away, by\n", int(farthest) + 1, from_first[farthest]);

  const Adjacency adjacency = Adjacency::build(std::make_shared<const Mesh>(*mesh));
  const auto at = [&](auto v) { return point_at_vertex(adjacency, mesh->vertex_of_source()[v]); };
  SolveScratch scratch;
  const auto pair = pair_search(Method::exact, {}, adjacency, {at(0)}, at(farthest),
                                PairPath::refined, scratch, Cancel());
  if (!pair || !pair->path) return 1;
  for (const auto& [point, p] : pair->path->points) std::printf("%g %g %g\n", p.x, p.y, p.z);
}
