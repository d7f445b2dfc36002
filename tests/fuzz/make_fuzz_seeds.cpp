// make_fuzz_seeds FOLDER: writes the seeds of every target into FOLDER/NAME.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/fuzz/targets.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_fuzz_seeds FOLDER\n");
    return 2;
  }
  for (const auto& target : geodesic::fuzz::targets()) {
    const auto folder = std::filesystem::path(argv[1]) / target.name;
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const std::string& seed : target.seeds()) {
      const auto path = folder / ("seed" + std::to_string(100 + number++));
      std::ofstream(path, std::ios::binary) << seed;
    }
  }
  return 0;
}
