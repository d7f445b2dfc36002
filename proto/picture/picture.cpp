#include "proto/picture/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/base/polled_fill.h"
#include "core/field/field.h"
#include "proto/picture/canvas.h"
#include "proto/picture/small_digits.h"

namespace geodesic::proto {
namespace {

constexpr Colour kPaper{255, 255, 255};
constexpr Colour kGrey{190, 192, 196};
constexpr Colour kInk{24, 24, 28};
constexpr Colour kLine{214, 39, 40};
// Above this many pixels a picture is drawn at its own size; below, at twice it and
// averaged. It bounds what one request takes.
constexpr std::uint64_t kSmoothPixels = 1'500'000;

double normal_length(Vec3 v) { return std::sqrt(dot(v, v)); }

Vec3 unit(Vec3 v) {
  const double length = normal_length(v);
  return length > 0 ? (1 / length) * v : Vec3{0, 0, 1};
}

Colour scaled(Colour colour, double light) {
  for (auto& channel : colour) {
    channel = static_cast<std::uint8_t>(std::clamp(channel * light, 0.0, 255.0));
  }
  return colour;
}

class Drawing {
 public:
  // What is drawn once the poll says to stop is cut short, and no result.
  Drawing(const Mesh& mesh, const PictureContent& content, const PictureOptions& options,
          Poll& poll)
      : poll_(poll),
        mesh_(mesh),
        content_(content),
        options_(options),
        scale_(std::uint64_t{options.width} * options.height <= kSmoothPixels ? 2 : 1),
        dot_(scale_ * (options.height >= 700 ? 2 : 1)),
        canvas_(options.width * scale_, options.height * scale_),
        frame_(frame_of(options.view.value_or(view_for(mesh)))) {
    for (const double value : content.values) {
      if (poll_.cancelled()) return;
      if (value != kUnreached) greatest_ = std::max(greatest_, value);
    }
    place();
  }

  Result<Image> draw() {
    shade_vertices();
    for (std::uint32_t f = 0; f < mesh_.face_count() && !poll_.cancelled(); ++f) {
      draw_face(mesh_.faces()[f]);
    }
    for (const Patch& patch : content_.patches) draw_patch(patch);
    const double thick = scale_ * std::max(1.5, 0.0022 * std::min(options_.width, options_.height));
    shine_through(thick);
    for (const auto& line : content_.lines) {
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        draw_capsule(on_screen(line[i]), on_screen(line[i + 1]), thick + 0.8 * scale_, kPaper);
      }
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        draw_capsule(on_screen(line[i]), on_screen(line[i + 1]), thick, kLine);
      }
    }
    for (const Vec3 p : content_.sources) draw_mark(p, 3 * thick, kInk, kInk);
    for (const Vec3 p : content_.targets) draw_mark(p, 3 * thick, kInk, kPaper);
    if (has_scale()) draw_scale();
    Image image = canvas_.reduced(scale_, poll_);
    if (poll_.stopped()) return fail_stopped(poll_);
    return image;
  }

 private:
  // There is something to read off, and room for it.
  [[nodiscard]] bool has_scale() const {
    return greatest_ > 0 && options_.width >= 3 * kScaleWidth;
  }

  // Fits the mesh into the canvas, beside the scale.
  void place() {
    Vec3 low{INFINITY, INFINITY, INFINITY};
    Vec3 high{-INFINITY, -INFINITY, -INFINITY};
    seen_.reserve(mesh_.vertex_count());
    for (const Vec3 p : mesh_.positions()) {
      if (poll_.cancelled()) return;
      const Vec3 s = frame_.seen(p);
      seen_.push_back(s);
      low = {std::min(low.x, s.x), std::min(low.y, s.y), std::min(low.z, s.z)};
      high = {std::max(high.x, s.x), std::max(high.y, s.y), std::max(high.z, s.z)};
    }
    const double margin = 0.04 * std::min(canvas_.width(), canvas_.height());
    const double beside = has_scale() ? scale_ * kScaleWidth : 0;
    const double width = canvas_.width() - beside - 2 * margin;
    const double height = canvas_.height() - 2 * margin;
    const Vec3 size = high - low;
    const double most = std::max({size.x, size.y, std::numeric_limits<double>::min()});
    pixels_per_unit_ =
        std::min(width / std::max(size.x, 1e-6 * most), height / std::max(size.y, 1e-6 * most));
    const Vec3 middle = 0.5 * (low + high);
    for (Vec3& s : seen_) {
      if (poll_.cancelled()) return;
      s = to_pixels(s - middle, margin + width / 2, margin + height / 2);
    }
    middle_ = middle;
    centre_x_ = margin + width / 2;
    centre_y_ = margin + height / 2;
    bias_ = 0.004 * pixels_per_unit_ * std::max({size.x, size.y, size.z});
  }
  [[nodiscard]] Vec3 to_pixels(Vec3 s, double x, double y) const {
    return {x + pixels_per_unit_ * s.x, y - pixels_per_unit_ * s.y, pixels_per_unit_ * s.z};
  }
  [[nodiscard]] Vec3 on_screen(Vec3 p) const {
    return to_pixels(frame_.seen(p) - middle_, centre_x_, centre_y_);
  }

  // A face's normal on the screen, turned to the eye whatever its winding; its
  // length is twice the area in pixels.
  [[nodiscard]] Vec3 facing_normal(const Triangle& t) const {
    Vec3 n = cross(seen_[t[1]] - seen_[t[0]], seen_[t[2]] - seen_[t[0]]);
    return n.z < 0 ? -1.0 * n : n;
  }

  void shade_vertices() {
    if (poll_.stopped()) return;  // not all is seen
    polled_assign(normals_, mesh_.vertex_count(), Vec3{0, 0, 0}, poll_);
    for (const Triangle& t : mesh_.faces()) {
      if (poll_.cancelled()) return;
      const Vec3 n = facing_normal(t);
      for (const std::uint32_t v : t) normals_[v] = normals_[v] + n;
    }
    for (Vec3& n : normals_) {
      if (poll_.cancelled()) return;
      n = unit(n);
    }
  }

  // Mostly from over the left shoulder, a little from everywhere.
  [[nodiscard]] static double light_on(Vec3 normal) {
    static const Vec3 lamp = unit({-0.4, -0.6, 1});
    return 0.42 + 0.62 * std::max(dot(normal, lamp), 0.0);
  }

  // At its corners. A crease: the mean of its sides' normals belongs to neither.
  [[nodiscard]] std::array<double, 3> light_on(const Triangle& t) const {
    const Vec3 flat = unit(facing_normal(t));
    std::array<double, 3> light{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 smooth = normals_[t[i]];
      light[i] = light_on(dot(flat, smooth) > 0.8 ? smooth : flat);
    }
    return light;
  }

  void draw_face(const Triangle& t) {
    const std::array<Vec3, 3> corners{seen_[t[0]], seen_[t[1]], seen_[t[2]]};
    const auto& [a, b, c] = corners;
    std::array<double, 3> value{};
    bool reached = !content_.values.empty();
    for (std::size_t i = 0; reached && i < 3; ++i) {
      value[i] = content_.values[t[i]];
      reached = value[i] != kUnreached;
    }
    // How fast the value changes from pixel to pixel: the same all over the face.
    double slope = 0;
    if (reached) {
      const double u = value[1] - value[0];
      const double v = value[2] - value[0];
      slope = std::hypot(u * (c.y - a.y) - v * (b.y - a.y), v * (b.x - a.x) - u * (c.x - a.x)) /
              std::abs(area2(corners));
    }
    draw_triangle(corners, light_on(t), 0, [&](double w0, double w1, double w2) {
      return reached ? colour_of(w0 * value[0] + w1 * value[1] + w2 * value[2], slope) : kGrey;
    });
  }

  void draw_patch(const Patch& patch) {
    for (std::size_t i = 0; i < patch.faces.size() && !poll_.cancelled(); ++i) {
      const Triangle& t = mesh_.faces()[patch.faces[i]];
      const std::array<Vec3, 3> face{seen_[t[0]], seen_[t[1]], seen_[t[2]]};
      if (!has_area(face)) continue;
      const std::array<double, 3> light = light_on(t);
      const auto [least, most] = std::minmax({light[0], light[1], light[2]});
      std::array<Vec3, 3> corners{};
      std::array<double, 3> light_at{};
      for (std::size_t c = 0; c < 3; ++c) {
        corners[c] = on_screen(patch.corners[3 * i + c]);
        const auto [w0, w1, w2] = weights_at(face, corners[c].x, corners[c].y);
        // Weights in a face that is seen from its side are little but rounding.
        light_at[c] = std::clamp(w0 * light[0] + w1 * light[1] + w2 * light[2], least, most);
      }
      draw_triangle(corners, light_at, kOverFace,
                    [&](double, double, double) { return patch.colour; });
    }
  }

  // Twice the area on the screen, with a sign.
  [[nodiscard]] static double area2(const std::array<Vec3, 3>& corners) {
    const auto& [a, b, c] = corners;
    return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  }

  [[nodiscard]] static bool has_area(const std::array<Vec3, 3>& corners) {
    return std::abs(area2(corners)) > 1e-12;
  }

  // Of the corners of a triangle that has an area, at a place on the screen.
  [[nodiscard]] static std::array<double, 3> weights_at(const std::array<Vec3, 3>& corners,
                                                        double x, double y) {
    const auto& [a, b, c] = corners;
    const double area = area2(corners);
    const double w1 = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
    const double w2 = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
    return {1 - w1 - w2, w1, w2};
  }

  // Where nothing is nearer to the eye by more than `over` pixels. `colour_by`: the colour by the
  // weights of the corners.
  template <class Colouring>
  void draw_triangle(const std::array<Vec3, 3>& corners, const std::array<double, 3>& light,
                     double over, Colouring&& colour_by) {
    const auto& [a, b, c] = corners;
    if (!has_area(corners)) return;
    const Span rows =
        pixels_between(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), canvas_.height());
    for (std::uint32_t y = rows.first; y < rows.end; ++y) {
      const Span columns = columns_in(a, b, c, y + 0.5);
      if (poll_.cancelled()) return;
      for (std::uint32_t x = columns.first; x < columns.end; ++x) {
        if (poll_.cancelled()) return;
        const auto [w0, w1, w2] = weights_at(corners, x + 0.5, y + 0.5);
        const auto depth = static_cast<float>(w0 * a.z + w1 * b.z + w2 * c.z + over);
        if (!(depth > canvas_.depth(x, y))) continue;
        canvas_.put(x, y, depth,
                    scaled(colour_by(w0, w1, w2), w0 * light[0] + w1 * light[1] + w2 * light[2]));
      }
    }
  }

  // The pixels of a row whose centres are in the triangle. Rounded outwards by a
  // hair, so that neighbours leave no gap; depth settles what both cover.
  [[nodiscard]] Span columns_in(Vec3 a, Vec3 b, Vec3 c, double y) const {
    double low = INFINITY;
    double high = -INFINITY;
    const std::array<std::array<Vec3, 2>, 3> sides{{{a, b}, {b, c}, {c, a}}};
    for (const auto& [p, q] : sides) {
      if ((p.y < y) == (q.y < y)) continue;
      const double x = p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y));
      low = std::min(low, x);
      high = std::max(high, x);
    }
    if (low > high) return {0, 0};
    return pixels_between(low - 1e-6, high + 1e-6, canvas_.width());
  }

  [[nodiscard]] Colour colour_of(double value, double slope) const {
    const Colour colour = colour_at(options_.colour_map, greatest_ > 0 ? value / greatest_ : 0);
    if (options_.stripes == 0 || !(slope > 0) || !(greatest_ > 0)) return colour;
    const double step = greatest_ / options_.stripes;
    const double nearest = std::round(value / step);
    // The last one would be a dot.
    if (nearest < 1 || nearest >= options_.stripes) return colour;
    const double pixels = std::abs(value - nearest * step) / slope;
    const double half = 0.55 * scale_;
    // Where stripes would run together, they fade instead.
    const double crowded = std::clamp(step / slope / (6.0 * scale_), 0.0, 1.0);
    const double ink = std::clamp(half + 0.5 - pixels, 0.0, 1.0) * crowded;
    return mixed(colour, kInk, 0.75 * ink);
  }

  // Lines where the surface hides them: faint, and each pixel once, or the joints
  // between segments would show.
  void shine_through(double thick) {
    if (content_.lines.empty()) return;
    std::vector<float> covered(std::size_t{canvas_.width()} * canvas_.height(), 0);
    for (const auto& line : content_.lines) {
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        for_capsule(on_screen(line[i]), on_screen(line[i + 1]), thick,
                    [&](std::uint32_t x, std::uint32_t y, double covers, bool) {
                      float& most = covered[std::size_t{y} * canvas_.width() + x];
                      most = std::max(most, static_cast<float>(covers));
                    });
      }
    }
    for (std::uint32_t y = 0; y < canvas_.height(); ++y) {
      for (std::uint32_t x = 0; x < canvas_.width(); ++x) {
        if (poll_.cancelled()) return;
        const float covers = covered[std::size_t{y} * canvas_.width() + x];
        if (covers > 0) canvas_.blend(x, y, kLine, 0.35 * covers);
      }
    }
  }

  // All pixels within `radius` of a segment on the screen: how much of each is
  // covered, and whether the surface hides it.
  template <class Visit>
  void for_capsule(Vec3 a, Vec3 b, double radius, Visit&& visit) {
    const Span rows =
        pixels_between(std::min(a.y, b.y) - radius, std::max(a.y, b.y) + radius, canvas_.height());
    const Span columns =
        pixels_between(std::min(a.x, b.x) - radius, std::max(a.x, b.x) + radius, canvas_.width());
    const double length2 = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
    if (poll_.cancelled()) return;
    for (std::uint32_t y = rows.first; y < rows.end; ++y) {
      for (std::uint32_t x = columns.first; x < columns.end; ++x) {
        if (poll_.cancelled()) return;
        const double dx = x + 0.5 - a.x;
        const double dy = y + 0.5 - a.y;
        const double along =
            length2 > 0 ? std::clamp((dx * (b.x - a.x) + dy * (b.y - a.y)) / length2, 0.0, 1.0) : 0;
        const double off = std::hypot(dx - along * (b.x - a.x), dy - along * (b.y - a.y));
        const double covers = std::clamp(radius + 0.5 - off, 0.0, 1.0);
        if (covers == 0) continue;
        const double depth = a.z + along * (b.z - a.z) + bias_ + radius;
        visit(x, y, covers, depth < canvas_.depth(x, y));
      }
    }
  }

  void draw_capsule(Vec3 a, Vec3 b, double radius, Colour colour) {
    for_capsule(a, b, radius, [&](std::uint32_t x, std::uint32_t y, double covers, bool hidden) {
      if (!hidden) canvas_.blend(x, y, colour, covers);
    });
  }

  void draw_mark(Vec3 p, double radius, Colour rim, Colour inside) {
    const Vec3 at = on_screen(p);
    draw_capsule(at, at, radius + scale_, kPaper);
    draw_capsule(at, at, radius, rim);
    draw_capsule(at, at, 0.55 * radius, inside);
  }

  void draw_scale() {
    const std::uint32_t margin = canvas_.height() / 10;
    const std::uint32_t top = margin;
    const std::uint32_t bottom = canvas_.height() - margin;
    const std::uint32_t left = canvas_.width() - scale_ * (kScaleWidth - 14);
    const std::uint32_t right = left + scale_ * 16;
    if (bottom <= top + 8) return;
    for (std::uint32_t y = top; y < bottom; ++y) {
      const double value = greatest_ * (bottom - 1 - y) / double(bottom - 1 - top);
      const Colour colour = colour_at(options_.colour_map, value / greatest_);
      for (std::uint32_t x = left; x < right; ++x) canvas_.paint(x, y, colour);
    }
    const double step = nice_step(greatest_ / 5);
    const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
    for (int i = 0; i * step <= greatest_ * (1 + 1e-9); ++i) {
      const auto y = static_cast<std::uint32_t>(
          std::lround(bottom - 1 - (bottom - 1 - top) * std::min(i * step / greatest_, 1.0)));
      for (std::uint32_t x = right; x < right + 4 * scale_ && x < canvas_.width(); ++x) {
        for (std::uint32_t j = 0; j < scale_; ++j) {
          if (y + j < canvas_.height()) canvas_.paint(x, y + j, kInk);
        }
      }
      char text[40];
      const bool plain = greatest_ < 1e5 && step > 1e-4;
      std::snprintf(text, sizeof text, plain ? "%.*f" : "%.*e", plain ? decimals : 1, i * step);
      write(text, right + 7 * scale_, static_cast<std::int64_t>(y) - kDigitHeight * dot_ / 2);
    }
  }

  // 1, 2 or 5 times a power of ten, at least `least`.
  static double nice_step(double least) {
    const double power = std::pow(10, std::floor(std::log10(least)));
    for (const double times : {1.0, 2.0, 5.0}) {
      if (times * power >= least * (1 - 1e-12)) return times * power;
    }
    return 10 * power;
  }

  void write(const char* text, std::uint32_t left, std::int64_t top) {
    for (; *text != '\0'; ++text, left += (kDigitWidth + 1) * dot_) {
      const auto rows = digit_rows(*text);
      for (std::uint32_t j = 0; j < kDigitHeight * dot_; ++j) {
        for (std::uint32_t i = 0; i < kDigitWidth * dot_; ++i) {
          const bool ink = ((rows[j / dot_] >> (kDigitWidth - 1 - i / dot_)) & 1U) != 0;
          const std::int64_t y = top + j;
          if (!ink || left + i >= canvas_.width() || y < 0 || y >= canvas_.height()) continue;
          canvas_.paint(left + i, static_cast<std::uint32_t>(y), kInk);
        }
      }
    }
  }

  static constexpr std::uint32_t kScaleWidth = 110;  // pixels of the picture
  static constexpr double kOverFace = 0.01;          // pixels towards the eye, more than rounding

  Poll& poll_;
  const Mesh& mesh_;
  const PictureContent& content_;
  const PictureOptions& options_;
  std::uint32_t scale_;  // pixels of the canvas to one of the picture, along each side
  std::uint32_t dot_;    // pixels of the canvas to a pixel of a digit, along each side
  Canvas canvas_;
  Frame frame_;
  std::vector<Vec3> seen_;  // positions in pixels, y downwards; z in pixels towards the eye
  std::vector<Vec3> normals_;
  double greatest_ = 0;
  double pixels_per_unit_ = 1;
  Vec3 middle_;
  double centre_x_ = 0;
  double centre_y_ = 0;
  double bias_ = 0;  // lines lie on the surface, not in it
};

}  // namespace

Result<Image> draw_picture(const Mesh& mesh, const PictureContent& content,
                           const PictureOptions& options, const Cancel& cancel) {
  Poll poll(cancel);
  return Drawing(mesh, content, options, poll).draw();
}

}  // namespace geodesic::proto
