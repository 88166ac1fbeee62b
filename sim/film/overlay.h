#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "sim/film/render_image.h"

namespace takt::sim {

/// What stands in the film beside the picture; an empty text or an absent value leaves its place free. Text is UTF-8;
/// what does not fit is cut with an ellipsis.
struct Overlay {
  enum class Tone { kPlain, kGood, kBad };
  std::string title;                    ///< of the scenario, upper left
  std::string step;                     ///< node of the program at work, lower left
  Tone step_tone = Tone::kPlain;        ///< its colour
  std::string path;                     ///< of the nodes around it, above it; cut on its left
  std::string camera;                   ///< upper right
  std::string note;                     ///< on a strip of its own above the step: why something failed
  Nanoseconds time = 0;                 ///< simulated time, lower right
  std::optional<double> force_N;        ///< the force to watch, as number and bar
  std::optional<double> force_limit_N;  ///< marked in the bar; above it the bar turns red
  std::string force_label = "Force";
  bool operator==(const Overlay&) const = default;
};

/// Draws overlays into pictures of one size: light text on translucent strips at the upper and lower edge, scaled with
/// the height of the picture. Keeps the glyphs it has drawn. Thread: one at a time. Realtime: setup.
class OverlayPainter {
 public:
  /// @return a diagnostic if the font (DejaVu Sans) is not on the machine
  [[nodiscard]] static Result<OverlayPainter> create(int width, int height);
  OverlayPainter(OverlayPainter&&) noexcept;
  OverlayPainter& operator=(OverlayPainter&&) noexcept;
  ~OverlayPainter();

  /// Draws into `image`, which has the size given to create(). What comes out depends on the arguments alone.
  void draw(const Overlay& overlay, Image& image);

 private:
  class Impl;
  explicit OverlayPainter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::sim
