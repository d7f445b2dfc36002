// paper_report FOLDER: computes the figures and tables of the report, as CSV, and
// what its pictures are drawn from, under FOLDER/arrays.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/wire/methods.h"
#include "tests/bench/subjects.h"
#include "tests/paper/report/report.h"

using namespace geodesic;

int main(int argc, char** argv) {
  CLI::App app("Computes what the report on the paper shows");
  std::string folder;
  bool small = false;
  app.add_option("folder", folder, "where the files go")->required();
  app.add_flag("--small", small, "small meshes and one round, for tests");
  CLI11_PARSE(app, argc, argv);

  report::Setting setting;
  setting.folder = folder;
  setting.arrays = setting.folder / "arrays";
  setting.scale = small ? bench::Scale::small : bench::Scale::full;
  for (const proto::MethodInfo& info : proto::all_methods()) setting.methods.push_back(info.method);
  std::error_code error;
  std::filesystem::create_directories(setting.arrays, error);
  if (error) {
    std::fprintf(stderr, "cannot make %s: %s\n", setting.arrays.c_str(), error.message().c_str());
    return 1;
  }

  std::vector<bench::Subject> subjects = bench::formula_subjects(setting.scale);
  if (!small) {
    for (auto& subject : bench::scanned_subjects()) subjects.push_back(std::move(subject));
  }
  report::plane(setting);
  report::planes_with_holes(setting);
  report::body(setting);
  report::against_novotni(setting, subjects);
  report::every_method(setting, subjects);
  return 0;
}
