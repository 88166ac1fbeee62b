#include "sim/film/overlay.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/film/overlay_font.h"

namespace takt::sim {
namespace {

constexpr Colour kText{244, 246, 248};
constexpr Colour kFaint{176, 186, 197};
constexpr Colour kStrip{14, 20, 28};
constexpr Colour kBar{86, 180, 233};  // blue and vermilion: told apart by colour-blind eyes, too
constexpr Colour kBarOver{240, 98, 52};
constexpr Colour kNumberOver{255, 148, 112};
constexpr Colour kGood{92, 214, 176};
constexpr Colour kNote{255, 214, 140};
constexpr Colour kNoteStrip{120, 36, 14};
constexpr int kStripOpacity = 165;
constexpr int kNoteOpacity = 205;

// Simulated time as people read it: "12.34 s", from a minute on "1:02.34".
std::string time_text(Nanoseconds time) {
  const Nanoseconds hundredths = std::max<Nanoseconds>(0, time) / (10 * kMillisecond);
  if (hundredths < 6000) return fmt::format("{}.{:02} s", hundredths / 100, hundredths % 100);
  return fmt::format("{}:{:02}.{:02}", hundredths / 6000, hundredths / 100 % 60, hundredths % 100);
}

std::string force_text(double force) {
  if (!std::isfinite(force)) return "\u2013 N";
  return std::abs(force) < 99.95 ? fmt::format("{:.1f} N", force) : fmt::format("{:.0f} N", force);
}

}  // namespace

class OverlayPainter::Impl {
 public:
  Impl(int width, int height, Font large, Font small)
      : width_(width), height_(height), large_(std::move(large)), small_(std::move(small)) {}

  void draw(const Overlay& overlay, Image& image) {
    draw_top(overlay, image);
    draw_bottom(overlay, image);
  }

 private:
  // Lengths are told for 720 lines.
  int scaled(double length) const { return static_cast<int>(std::lround(length * height_ / 720)); }

  void draw_top(const Overlay& overlay, Image& image) {
    if (overlay.title.empty() && overlay.camera.empty()) return;
    const int strip = scaled(38), margin = scaled(20), base = scaled(26);
    fill_rectangle(image, 0, 0, width_, strip, kStrip, kStripOpacity);
    const std::string camera = small_.fitted(overlay.camera, width_ / 3);
    small_.draw(camera, width_ - margin - small_.width(camera), base, kFaint, image);
    const int room = width_ - 3 * margin - small_.width(camera);
    small_.draw(small_.fitted(overlay.title, room), margin, base, kText, image);
  }

  void draw_bottom(const Overlay& overlay, Image& image) {
    const int strip = scaled(56), margin = scaled(20);
    const int top = height_ - strip, base = top + scaled(36);
    fill_rectangle(image, 0, top, width_, strip, kStrip, kStripOpacity);
    const std::string time = time_text(overlay.time);
    // Room for a fixed number of digits, so that nothing shifts while time runs.
    int right = width_ - margin - large_.width("00:00.00");
    large_.draw(time, width_ - margin - large_.width(time), base, kText, image);
    if (overlay.force_N) right = draw_force(overlay, right - margin, base, image);
    draw_step(overlay, margin, right - 2 * margin, base, image);
    if (!overlay.note.empty()) draw_note(overlay.note, top, image);
  }

  static Colour colour_of(Overlay::Tone tone) {
    return tone == Overlay::Tone::kGood ? kGood : tone == Overlay::Tone::kBad ? kNumberOver : kText;
  }

  void draw_step(const Overlay& overlay, int left, int room, int base, Image& image) {
    if (overlay.path.empty()) {
      large_.draw(large_.fitted(overlay.step, room), left, base, colour_of(overlay.step_tone), image);
      return;
    }
    const int up = scaled(16), down = scaled(9);
    small_.draw(small_.fitted_end(overlay.path, room), left, base - up, kFaint, image);
    large_.draw(large_.fitted(overlay.step, room), left, base + down, colour_of(overlay.step_tone), image);
  }

  // On a strip of its own that ends at `bottom`.
  void draw_note(const std::string& note, int bottom, Image& image) {
    const int strip = scaled(34), margin = scaled(20);
    fill_rectangle(image, 0, bottom - strip, width_, strip, kNoteStrip, kNoteOpacity);
    small_.draw(small_.fitted(note, width_ - 2 * margin), margin, bottom - strip + scaled(23), kNote, image);
  }

  // Label, number and bar, from the right; returns the left edge.
  int draw_force(const Overlay& overlay, int right, int base, Image& image) {
    const int bar_width = scaled(190), bar_height = scaled(14);
    const int bar_left = right - bar_width, bar_top = base - bar_height;
    const double force = std::isfinite(*overlay.force_N) ? std::max(0.0, *overlay.force_N) : 0;
    const double limit = overlay.force_limit_N.value_or(0);
    const bool over = limit > 0 && force > limit;
    // The limit stands at three quarters; without one the bar covers decades.
    const double full = limit > 0 ? limit / 0.75 : std::pow(10.0, std::ceil(std::log10(std::max(force, 10.0)) - 1e-9));
    fill_rectangle(image, bar_left, bar_top, bar_width, bar_height, kText, 50);
    const int filled = static_cast<int>(std::lround(bar_width * std::min(1.0, force / full)));
    fill_rectangle(image, bar_left, bar_top, filled, bar_height, over ? kBarOver : kBar, 255);
    if (limit > 0) {
      const int overhang = scaled(5);
      fill_rectangle(image, bar_left + bar_width * 3 / 4 - scaled(1), bar_top - overhang, std::max(2, scaled(3)),
                     bar_height + 2 * overhang, kText, 255);
    }
    const std::string number = force_text(*overlay.force_N);
    const int number_right = bar_left - scaled(12);
    small_.draw(number, number_right - small_.width(number), base - scaled(1), over ? kNumberOver : kText, image);
    const int label_right = number_right - small_.width("0000.0 N") - scaled(8);
    const std::string label = small_.fitted(overlay.force_label, scaled(220));
    small_.draw(label, label_right - small_.width(label), base - scaled(1), kFaint, image);
    return label_right - small_.width(label);
  }

  int width_, height_;
  Font large_, small_;
};

OverlayPainter::OverlayPainter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OverlayPainter::OverlayPainter(OverlayPainter&&) noexcept = default;
OverlayPainter& OverlayPainter::operator=(OverlayPainter&&) noexcept = default;
OverlayPainter::~OverlayPainter() = default;

Result<OverlayPainter> OverlayPainter::create(int width, int height) {
  Result<Font> large = Font::open(Font::Weight::kBold, height * 25 / 720);
  if (!large) return std::unexpected(large.error());
  Result<Font> small = Font::open(Font::Weight::kBook, height * 19 / 720);
  if (!small) return std::unexpected(small.error());
  return OverlayPainter(std::make_unique<Impl>(width, height, std::move(*large), std::move(*small)));
}

void OverlayPainter::draw(const Overlay& overlay, Image& image) { impl_->draw(overlay, image); }

}  // namespace takt::sim
