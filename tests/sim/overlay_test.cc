#include "sim/film/overlay.h"

#include <limits>

#include <gtest/gtest.h>

#include "sim/film/overlay_font.h"

namespace takt::sim {
namespace {

constexpr int kWidth = 640, kHeight = 360;

Image background() {
  Image image;
  image.resize(kWidth, kHeight);
  std::ranges::fill(image.rgba, std::uint8_t{90});
  return image;
}

Image painted(const Overlay& overlay) {
  Result<OverlayPainter> painter = OverlayPainter::create(kWidth, kHeight);
  EXPECT_TRUE(painter) << painter.error().to_string();
  Image image = background();
  painter->draw(overlay, image);
  return image;
}

// Bright pixels, that is text, in a part of the picture.
int text_pixels(const Image& image, int left, int top, int width, int height) {
  int count = 0;
  for (int y = top; y < top + height; ++y)
    for (int x = left; x < left + width; ++x) count += image.pixel(x, y)[1] > 150 ? 1 : 0;
  return count;
}

TEST(Overlay, EveryTextHasItsCorner) {
  Overlay overlay;
  overlay.title = "Two arms";
  overlay.camera = "main camera";
  overlay.step = "approach";
  overlay.time = 1'230 * kMillisecond;
  const Image image = painted(overlay);
  EXPECT_GT(text_pixels(image, 0, 0, 160, 19), 30);
  EXPECT_GT(text_pixels(image, 480, 0, 160, 19), 30);
  EXPECT_GT(text_pixels(image, 0, 332, 160, 28), 30);
  EXPECT_GT(text_pixels(image, 540, 332, 100, 28), 30);
  EXPECT_EQ(text_pixels(image, 0, 19, kWidth, 313), 0);
}

TEST(Overlay, TheBarGrowsWithTheForceAndTurnsRedAboveTheLimit) {
  const auto count = [](double force, bool red) {
    Overlay overlay;
    overlay.force_N = force;
    overlay.force_limit_N = 20;
    const Image image = painted(overlay);
    int pixels = 0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const std::uint8_t* p = image.pixel(i % kWidth, i / kWidth);
      pixels += (red ? p[0] > 200 && p[2] < 80 : p[2] > 200 && p[0] < 110) ? 1 : 0;
    }
    return pixels;
  };
  EXPECT_EQ(count(0, false), 0);
  EXPECT_GT(count(10, false), 1.8 * count(5, false));
  EXPECT_LT(count(10, false), 2.2 * count(5, false));
  EXPECT_EQ(count(19.9, true), 0);
  EXPECT_EQ(count(20.1, false), 0);
  EXPECT_GT(count(20.1, true), 100);
}

TEST(Overlay, AnyTextAndNumberIsDrawnWithinThePicture) {
  Overlay overlay;
  overlay.title = std::string(5000, 'W');
  overlay.step = "Gr\u00fc\u00dfe \xff\xc3 \xf0\x9f\xa4\x96 \xed\xa0\x80" + std::string(300, '.');
  overlay.note = std::string(1000, '\n');
  overlay.time = std::numeric_limits<Nanoseconds>::max();
  for (const double force :
       {-1.0, 1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    overlay.force_N = force;
    EXPECT_NE(painted(overlay), background());
  }
  EXPECT_EQ(painted(overlay), painted(overlay));
}

TEST(Font, WhatItLacksComesFromAnother) {
  // The letter A of mathematics, without serifs: in DejaVu Sans, and not in its bold face. The last one is in no font.
  const auto drawn = [](const char* text) {
    Font font = Font::open(Font::Weight::kBold, 24).value();
    Image image = background();
    font.draw(text, 4, 30, {}, image);
    return image.rgba;
  };
  EXPECT_NE(drawn("\U0001D5A0"), drawn("\U0010FFFD")) << "no empty box";
  EXPECT_NE(drawn("\U0001D5A0"), drawn("\U0001D5A1"));
  EXPECT_EQ(drawn("\U0010FFFE"), drawn("\U0010FFFD"));
}

TEST(Font, FittedTextIsNoWiderThanAskedAndKeepsWholeCharacters) {
  Result<Font> font = Font::open(Font::Weight::kBook, 19);
  ASSERT_TRUE(font);
  const std::string text = "Werkst\u00fcck \u00fcber \u00d6ffnung";
  for (int most = 30; most < 300; most += 7) {
    const std::string fitted = font->fitted(text, most);
    EXPECT_LE(font->width(fitted), most);
    EXPECT_EQ(fitted.find("\xef\xbf\xbd"), std::string::npos);
  }
  EXPECT_EQ(font->fitted(text, 1000), text);
}

}  // namespace
}  // namespace takt::sim
