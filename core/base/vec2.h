// A point or vector in the plane that faces are unfolded into, in mesh units.
#pragma once

#include <cmath>

namespace geodesic {

struct Vec2 {
  double x = 0;
  double y = 0;

  friend Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend Vec2 operator-(Vec2 a) { return {-a.x, -a.y}; }
  friend Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
  friend bool operator==(Vec2 a, Vec2 b) = default;
};

[[nodiscard]] inline double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
// Positive when b is to the left of a.
[[nodiscard]] inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
[[nodiscard]] inline double norm(Vec2 a) { return std::sqrt(dot(a, a)); }
// Of length one; a vector without length stays as it is.
[[nodiscard]] inline Vec2 unit(Vec2 a) {
  const double length = norm(a);
  return length > 0 ? Vec2{a.x / length, a.y / length} : a;
}
// Between 0 and pi, accurate for small angles too.
[[nodiscard]] inline double angle_between(Vec2 a, Vec2 b) {
  return std::atan2(std::abs(cross(a, b)), dot(a, b));
}

}  // namespace geodesic
