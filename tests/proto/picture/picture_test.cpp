#include "proto/picture/picture.h"

#include <doctest/doctest.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/field/field.h"
#include "core/mesh/shapes.h"

using namespace geodesic;
using proto::Colour;
using proto::Image;

namespace {

Colour pixel(const Image& image, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* at = &image.rgb[3 * (std::size_t{y} * image.width + x)];
  return {at[0], at[1], at[2]};
}

// Hue and saturation apart from the light: each channel over the greatest.
std::array<double, 3> tint(Colour colour) {
  const double most = std::max({colour[0], colour[1], colour[2], std::uint8_t{1}});
  return {colour[0] / most, colour[1] / most, colour[2] / most};
}

Image drawn(const Mesh& mesh, const proto::PictureContent& content,
            const proto::PictureOptions& options) {
  auto image = proto::draw_picture(mesh, content, options, Cancel());
  REQUIRE(image.has_value());
  REQUIRE(image->rgb.size() == std::size_t{3} * options.width * options.height);
  return std::move(*image);
}

Mesh plane(std::uint32_t side) {
  auto mesh = Mesh::build(shapes::plane(side, side));
  REQUIRE(mesh.has_value());
  return std::move(*mesh);
}

}  // namespace

TEST_CASE("PictureColoursThePlaneByItsValues") {
  const Mesh mesh = plane(21);
  std::vector<double> values;
  for (const Vec3 p : mesh.positions()) values.push_back(p.x);
  proto::PictureOptions options;
  options.width = 400;
  options.height = 300;
  options.stripes = 0;
  const Image image = drawn(mesh, {values, {}, {}, {}}, options);
  CHECK(pixel(image, 1, 1) == Colour{255, 255, 255});
  // Beside the scale of 110 pixels, the plane is a square round x = 145.
  for (const double t : {0.1, 0.5, 0.9}) {
    const auto x = static_cast<std::uint32_t>(145 + 266 * (t - 0.5));
    const auto expected = tint(proto::colour_at(proto::ColourMap::viridis, t));
    const auto found = tint(pixel(image, x, 150));
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(found[i] - expected[i]) < 0.03);
  }
}

// Each half in a colour of its own, and one corner in none. A face is cut where the halves meet.
TEST_CASE("PictureHasPatchesInTheirColours") {
  const Mesh mesh = plane(2);
  proto::PictureOptions options;
  options.width = options.height = 200;
  const Colour red{200, 40, 40};
  const Colour blue{40, 40, 200};
  const auto& faces = mesh.faces();
  std::vector<std::vector<Vec3>> corners(2);
  std::vector<std::vector<std::uint32_t>> in_faces(2);
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const auto at = [&](std::size_t c) { return mesh.positions()[faces[f][c % 3]]; };
    // From the corner at which the right angle is to the middle of the long side.
    std::size_t c = 0;
    while (dot(at(c + 1) - at(c), at(c + 2) - at(c)) > 1e-9) ++c;
    const Vec3 middle = 0.5 * (at(c + 1) + at(c + 2));
    for (const std::size_t side : {c + 1, c + 2}) {
      // Left and below, or right and above.
      const Vec3 sum = at(c) + at(side) + middle;
      const auto half = static_cast<std::size_t>(sum.x + 0.1 * sum.y > 1.65);
      for (const Vec3 corner : {at(c), at(side), middle}) corners[half].push_back(corner);
      in_faces[half].push_back(f);
    }
  }
  corners[1].resize(corners[1].size() - 3);
  in_faces[1].pop_back();
  proto::PictureContent content;
  content.patches = {{corners[0], in_faces[0], red}, {corners[1], in_faces[1], blue}};
  const Image image = drawn(mesh, content, options);
  std::array<int, 3> counts{};
  for (std::uint32_t y = 0; y < 200; ++y) {
    for (std::uint32_t x = 0; x < 200; ++x) {
      const auto found = tint(pixel(image, x, y));
      if (pixel(image, x, y) == Colour{255, 255, 255}) continue;
      counts[found[2] < 0.5 ? 0 : found[0] < 0.5 ? 1 : 2] += 1;
    }
  }
  // Quarters of the square of 184 pixels.
  CHECK(counts[0] == doctest::Approx(184 * 184 / 2).epsilon(0.02));
  CHECK(counts[1] == doctest::Approx(184 * 184 / 4).epsilon(0.02));
  CHECK(counts[2] == doctest::Approx(184 * 184 / 4).epsilon(0.02));
}

TEST_CASE("PictureHidesWhatIsBehindTheSurface") {
  const Mesh mesh = plane(5);
  proto::PictureOptions options;
  options.width = options.height = 200;
  const auto reds = [&](double z) {
    proto::PictureContent content;
    content.lines = {{{1, 2, z}, {3, 2, z}}};
    const Image image = drawn(mesh, content, options);
    int count = 0;
    for (std::uint32_t x = 0; x < 200; ++x) {
      const Colour c = pixel(image, x, 100);
      if (c[0] > 150 && c[1] < 80 && c[2] < 80) ++count;
    }
    return count;
  };
  CHECK(reds(0) > 80);  // half of the square's 184 pixels
  CHECK(reds(-1) == 0);
}

TEST_CASE("PictureHasStripesWhereAskedFor") {
  const Mesh mesh = plane(21);
  std::vector<double> values;
  for (const Vec3 p : mesh.positions()) values.push_back(p.x);
  proto::PictureOptions options;
  options.width = 600;
  options.height = 400;
  const auto dark_runs = [&](std::uint32_t stripes) {
    options.stripes = stripes;
    options.colour_map = proto::ColourMap::turbo;
    const Image image = drawn(mesh, {values, {}, {}, {}}, options);
    options.stripes = 0;
    const Image plain = drawn(mesh, {values, {}, {}, {}}, options);
    int runs = 0;
    bool in_run = false;
    for (std::uint32_t x = 0; x < 480; ++x) {
      const Colour a = pixel(image, x, 200);
      const Colour b = pixel(plain, x, 200);
      const bool dark = a[0] + a[1] + a[2] + 30 < b[0] + b[1] + b[2];
      if (dark && !in_run) ++runs;
      in_run = dark;
    }
    return runs;
  };
  CHECK(dark_runs(0) == 0);
  CHECK(dark_runs(5) >= 4);  // the fifth is the edge of the square
  CHECK(dark_runs(5) <= 5);
}

TEST_CASE("PictureOfUnreachedVerticesIsGrey") {
  const Mesh mesh = plane(3);
  const std::vector<double> values(9, kUnreached);
  proto::PictureOptions options;
  options.width = options.height = 100;
  const Image image = drawn(mesh, {values, {}, {}, {}}, options);
  const Colour c = pixel(image, 20, 50);
  CHECK(std::abs(int(c[0]) - int(c[2])) < 12);
  CHECK(c[0] < 250);
}

TEST_CASE("ViewsAreNamesOrAngles") {
  CHECK(proto::parse_view("left")->azimuth == -90);
  CHECK(proto::parse_view("12.5,-30")->elevation == -30);
  for (const char* wrong : {"", "up", "1", "1,", ",1", "1,2,3", "nan,1", "1e9,0", "1 ,2"}) {
    CAPTURE(wrong);
    REQUIRE_FALSE(proto::parse_view(wrong).has_value());
    CHECK(proto::parse_view(wrong).error().parameter == "view");
  }
}

TEST_CASE("PngHoldsThePixels") {
  Image image{7, 5, {}};
  for (std::size_t i = 0; i < 3 * 7 * 5; ++i) {
    image.rgb.push_back(static_cast<std::uint8_t>(37 * i + 11));
  }
  const std::string bytes = proto::encode_png(image);
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&read, bytes.data(), bytes.size()) != 0);
  CHECK(read.width == 7);
  CHECK(read.height == 5);
  read.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(read));
  REQUIRE(png_image_finish_read(&read, nullptr, pixels.data(), 0, nullptr) != 0);
  CHECK(pixels == image.rgb);
}

TEST_CASE("PictureOfANeedleAndOfASpeckEndsAndIsFinite") {
  for (const TriangleSoup& soup :
       {TriangleSoup{{{0, 0, 0}, {1e9, 0, 0}, {0, 1e-9, 0}}, {{0, 1, 2}}},
        TriangleSoup{{{0, 0, 0}, {1e-30, 0, 0}, {0, 1e-30, 1e-30}}, {{0, 1, 2}}}}) {
    auto mesh = Mesh::build(soup);
    REQUIRE(mesh.has_value());
    const std::vector<double> values{0, 1e-30, kUnreached};
    proto::PictureOptions options;
    options.width = options.height = 64;
    drawn(*mesh, {values, {{{0, 0, 0}, {1e9, 0, 0}}}, {{0, 0, 0}}, {{1, 1, 1}}}, options);
  }
}
