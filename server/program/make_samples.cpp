// Writes the sample meshes, each as .glb and .drc, into a folder.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/encode/encode_mesh.h"

using namespace geodesic;

namespace {

void write(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.exceptions(std::ios::failbit | std::ios::badbit);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  std::printf("%s %zu bytes\n", file.filename().c_str(), bytes.size());
}

// glTF has y up; the shapes have their heights in z.
TriangleSoup stood_upright(TriangleSoup soup) {
  for (Vec3& p : soup.positions) p = {p.x, p.z, -p.y};
  return soup;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_samples FOLDER\n");
    return 2;
  }
  struct Sample {
    std::string name;
    TriangleSoup soup;
  };
  // The planes are those of Figs. 5, 6 and 7 of Tang et al. 2007.
  const std::vector<shapes::Hole> one{{33, 33, 33}};
  const std::vector<shapes::Hole> two{{15, 25, 30}, {55, 45, 30}};
  const std::vector<shapes::Hole> three{{15, 25, 30}, {55, 45, 30}, {60, 8, 25}};
  const Sample samples[] = {{"plane", shapes::plane(100, 100)},
                            {"plane_one_hole", shapes::plane_with_holes(100, 100, one)},
                            {"plane_two_holes", shapes::plane_with_holes(100, 100, two)},
                            {"plane_three_holes", shapes::plane_with_holes(100, 100, three)},
                            {"sphere", shapes::icosphere(5)},
                            {"torus_knot", shapes::torus_knot(600, 32, 0.4)},
                            {"terrain", stood_upright(shapes::terrain(180, 18, 7))},
                            {"saddle", stood_upright(shapes::saddle(120, 30))}};
  try {
    const std::filesystem::path folder = argv[1];
    std::filesystem::create_directories(folder);
    for (const Sample& sample : samples) {
      write(folder / (sample.name + ".glb"), proto::encode_glb(sample.soup, sample.name));
      const auto drc = proto::encode_drc(sample.soup, 16);
      if (!drc) {
        std::fprintf(stderr, "make_samples: %s: %s\n", sample.name.c_str(),
                     drc.error().detail.c_str());
        return 1;
      }
      write(folder / (sample.name + ".drc"), *drc);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_samples: %s\n", error.what());
    return 1;
  }
  return 0;
}
