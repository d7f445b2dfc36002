// The experiments of Tang et al. 2007, section 4, one function a group of figures.
// Each computes with core and writes tables and arrays into a folder; pictures and
// text are made from these files alone (draw_figures.py, write_report.py).
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "core/field/method.h"
#include "tests/bench/subjects.h"

namespace geodesic::report {

struct Setting {
  std::filesystem::path folder;  // of the tables
  std::filesystem::path arrays;  // of what only pictures need
  bench::Scale scale = bench::Scale::full;
  std::vector<Method> methods;
};

// Fig. 5: fig5.csv (the errors of each method) and the field.
void plane(const Setting& setting);
// Figs. 6 and 7: holes.csv (corner to corner by each method) and fields with paths.
void planes_with_holes(const Setting& setting);
// Fig. 8: body.csv (the paths) and the field from the top of the nose.
void body(const Setting& setting);
// Where the two cases that Tang et al. added matter: novotni.csv and maps.
void against_novotni(const Setting& setting, std::span<const bench::Subject> subjects);
// Every method on every mesh: table.csv; what `exact` itself is worth: exact.csv;
// the paper's timing and memory: timing.csv.
void every_method(const Setting& setting, std::span<const bench::Subject> subjects);

}  // namespace geodesic::report
