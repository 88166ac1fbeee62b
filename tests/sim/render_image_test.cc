#include "sim/film/render_image.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::sim {
namespace {

Image grey(int width, int height, std::uint8_t level) {
  Image image;
  image.resize(width, height);
  std::ranges::fill(image.rgba, level);
  return image;
}

void set_grey(Image& image, int x, int y, double level) {
  for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::lround(level));
}

// Black where a x + b y < c, by the pixel's centre; or by the share of 16x16 sub-pixels.
Image half_plane(double a, double b, double c, bool exact) {
  Image image = grey(64, 64, 255);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      double light = a * (x + 0.5) + b * (y + 0.5) < c ? 0 : 1;
      if (exact) {
        light = 0;
        for (int i = 0; i < 256; ++i)
          light += a * (x + (i % 16 + 0.5) / 16) + b * (y + (i / 16 + 0.5) / 16) < c ? 0 : 1.0 / 256;
      }
      set_grey(image, x, y, 40 + 180 * light);
    }
  return image;
}

double squared_error(const Image& a, const Image& b) {
  double sum = 0;
  for (int y = 4; y < 60; ++y)
    for (int x = 4; x < 60; ++x) sum += std::pow(a.pixel(x, y)[0] - b.pixel(x, y)[0], 2);
  return sum;
}

TEST(EdgeSmoother, ComesCloserToTheTrueCoverageOfSlantedEdges) {
  EdgeSmoother smoother;
  Random random(1);
  double before = 0, after = 0;
  for (int i = 0; i < 60; ++i) {
    const double angle = random.uniform(0, 6.28), offset = random.uniform(-8, 8);
    const double a = std::cos(angle), b = std::sin(angle), c = 32 * (a + b) + offset;
    Image image = half_plane(a, b, c, false);
    const Image truth = half_plane(a, b, c, true);
    before += squared_error(image, truth);
    smoother.smooth(image);
    after += squared_error(image, truth);
  }
  EXPECT_LT(after, 0.5 * before);
}

TEST(EdgeSmoother, LeavesFlatAreasAndUprightEdgesAlone) {
  EdgeSmoother smoother;
  for (const Image& original : {grey(32, 24, 120), half_plane(1, 0, 32, false), half_plane(0, 1, 20, false)}) {
    Image image = original;
    smoother.smooth(image);
    EXPECT_EQ(image, original);
  }
}

TEST(EdgeSmoother, SurvivesTinyPicturesAndNoise) {
  EdgeSmoother smoother;
  Random random(2);
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 5}, {3, 3}, {17, 4}, {64, 64}}) {
    Image image = grey(width, height, 0);
    for (auto& byte : image.rgba) byte = static_cast<std::uint8_t>(random.bits());
    Image again = image;
    smoother.smooth(image);
    smoother.smooth(again);
    EXPECT_EQ(image, again);
  }
}

TEST(Paste, CutsOffWhatHangsOver) {
  for (const auto& [left, top] : {std::pair{-5, -5}, {28, 20}, {-40, 3}, {5, 60}, {10, 10}}) {
    Image target = grey(32, 24, 0);
    paste(grey(12, 10, 200), target, left, top, 1);
    int pasted = 0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 32; ++x) {
        const bool inside = x >= left && x < left + 12 && y >= top && y < top + 10;
        EXPECT_EQ(target.pixel(x, y)[0] == 200, inside);
        pasted += inside ? 1 : 0;
      }
  }
}

}  // namespace
}  // namespace takt::sim
