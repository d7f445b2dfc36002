// The pixels that a picture is drawn in: with depths, and perhaps larger than it
// will be.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "proto/picture/colour_map.h"
#include "proto/picture/picture.h"

namespace geodesic::proto {

[[nodiscard]] inline Colour mixed(Colour a, Colour b, double part_of_b) {
  for (std::size_t i = 0; i < 3; ++i) {
    a[i] = static_cast<std::uint8_t>(std::lround(a[i] + part_of_b * (b[i] - a[i])));
  }
  return a;
}

class Canvas {
 public:
  Canvas(std::uint32_t width, std::uint32_t height)
      : width_(width),
        height_(height),
        depth_(std::size_t{width} * height, -std::numeric_limits<float>::infinity()),
        rgb_(std::size_t{3} * width * height, 255) {}

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  [[nodiscard]] float depth(std::uint32_t x, std::uint32_t y) const {
    return depth_[std::size_t{y} * width_ + x];
  }
  void put(std::uint32_t x, std::uint32_t y, float depth, Colour colour) {
    depth_[std::size_t{y} * width_ + x] = depth;
    paint(x, y, colour);
  }
  void paint(std::uint32_t x, std::uint32_t y, Colour colour) {
    std::copy(colour.begin(), colour.end(), &rgb_[3 * (std::size_t{y} * width_ + x)]);
  }
  void blend(std::uint32_t x, std::uint32_t y, Colour colour, double part) {
    std::uint8_t* pixel = &rgb_[3 * (std::size_t{y} * width_ + x)];
    const Colour result = mixed({pixel[0], pixel[1], pixel[2]}, colour, part);
    std::copy(result.begin(), result.end(), pixel);
  }

  // Averages squares of `scale` x `scale` pixels, until the poll says to stop.
  [[nodiscard]] Image reduced(std::uint32_t scale, Poll& poll) const {
    Image image{width_ / scale, height_ / scale, {}};
    image.rgb.resize(std::size_t{3} * image.width * image.height);
    for (std::uint32_t y = 0; y < image.height; ++y) {
      for (std::uint32_t x = 0; x < image.width; ++x) {
        if (poll.cancelled()) return image;
        for (std::size_t channel = 0; channel < 3; ++channel) {
          std::uint32_t sum = 0;
          for (std::uint32_t j = 0; j < scale; ++j) {
            for (std::uint32_t i = 0; i < scale; ++i) {
              sum += rgb_[3 * ((std::size_t{y} * scale + j) * width_ + x * scale + i) + channel];
            }
          }
          image.rgb[3 * (std::size_t{y} * image.width + x) + channel] =
              static_cast<std::uint8_t>(sum / (scale * scale));
        }
      }
    }
    return image;
  }

 private:
  std::uint32_t width_;
  std::uint32_t height_;
  std::vector<float> depth_;
  std::vector<std::uint8_t> rgb_;
};

// Whole pixels whose centres may lie in [low, high], within [0, count).
struct Span {
  std::uint32_t first, end;
};
[[nodiscard]] inline Span pixels_between(double low, double high, std::uint32_t count) {
  const double first = std::clamp(std::ceil(low - 0.5), 0.0, double(count));
  const double end = std::clamp(std::floor(high - 0.5) + 1, first, double(count));
  return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end)};
}

}  // namespace geodesic::proto
