// A computation that says how far it has come, and ends when its time is over.
//
//     cancel_with_progress SECONDS
#include <geodesic/mesh/shapes.h>
#include <geodesic/solve/solve_field.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

using namespace geodesic;
using Clock = std::chrono::steady_clock;

int main(int argc, char** argv) {
  const std::chrono::duration<double> allowed(argc == 2 ? std::atof(argv[1]) : 60);
  auto mesh = std::make_shared<const Mesh>(*Mesh::build(shapes::terrain(300, 5, 1)));
  const Adjacency adjacency = Adjacency::build(mesh);

  const auto begun = Clock::now();
  int percent = 0;
  const Cancel cancel([&] { return Clock::now() - begun > allowed; },  // asked now and then
                      [&](double done) {                               // told now and then
                        if (int(100 * done) < percent + 10) return;
                        percent = int(100 * done);
                        std::printf("%d %%\n", percent);
                      });
  SolveScratch scratch;
  const Source source{point_at_vertex(adjacency, 0), 0};
  const auto field = solve_field(Method::exact, {}, adjacency, {&source, 1}, {}, scratch, cancel);
  if (!field) {
    std::printf("stopped: %s\n", field.error().detail.c_str());
    return field.error().code == ErrorCode::cancelled ? 2 : 1;
  }
  std::printf("%u vertices, the farthest %.6f away\n", unsigned(field->reached), field->max);
}
