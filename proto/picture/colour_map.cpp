#include "proto/picture/colour_map.h"

#include <algorithm>
#include <cmath>

namespace geodesic::proto {
namespace {

constexpr std::size_t kStops = 17;
using Stops = std::array<std::uint32_t, kStops>;

// Evenly spaced stops, 0xrrggbb, with straight lines between them: nowhere farther
// than 0.03 of a channel from the full tables.
// Viridis and magma: van der Walt and Smith 2015. Turbo: Mikhailov 2019.
constexpr Stops kViridis{0x440154, 0x48186a, 0x472d7b, 0x424086, 0x3b528b, 0x33638d,
                         0x2c728e, 0x26828e, 0x21918c, 0x1f9f88, 0x27ad81, 0x3dbc74,
                         0x5cc863, 0x81d34d, 0xaadc32, 0xd5e21a, 0xfde725};
constexpr Stops kMagma{0x000004, 0x0a0822, 0x1d1147, 0x36106b, 0x51127c, 0x6a1c81,
                       0x832681, 0x9c2e7f, 0xb73779, 0xcf4070, 0xe55064, 0xf4695c,
                       0xfb8761, 0xfea571, 0xfec287, 0xfde0a1, 0xfcfdbf};
constexpr Stops kTurbo{0x30123b, 0x4040a2, 0x466be3, 0x4294ff, 0x28bceb, 0x18ddc2,
                       0x32f298, 0x6dfe62, 0xa4fc3c, 0xcbed34, 0xecd13a, 0xfdae35,
                       0xfb8122, 0xec530f, 0xd23105, 0xac1701, 0x7a0403};

const Stops& stops_of(ColourMap map) {
  switch (map) {
    case ColourMap::magma:
      return kMagma;
    case ColourMap::turbo:
      return kTurbo;
    case ColourMap::viridis:
      break;
  }
  return kViridis;
}

}  // namespace

Result<ColourMap> find_colour_map(std::string_view name) {
  if (name == "viridis") return ColourMap::viridis;
  if (name == "magma") return ColourMap::magma;
  if (name == "turbo") return ColourMap::turbo;
  return fail(ErrorCode::value_out_of_range, "colormap is one of viridis, magma, turbo",
              "colormap");
}

Colour colour_at(ColourMap map, double t) {
  const double place = std::clamp(t, 0.0, 1.0) * (kStops - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kStops - 2);
  const double part = place - static_cast<double>(low);
  const Stops& stops = stops_of(map);
  Colour colour;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const std::uint32_t shift = 16 - 8 * static_cast<std::uint32_t>(channel);
    const double a = (stops[low] >> shift) & 0xffU;
    const double b = (stops[low + 1] >> shift) & 0xffU;
    colour[channel] = static_cast<std::uint8_t>(std::lround(a + part * (b - a)));
  }
  return colour;
}

}  // namespace geodesic::proto
