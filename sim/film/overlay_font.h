#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"
#include "sim/film/render_image.h"

namespace takt::sim {

struct Colour {
  std::uint8_t r = 255, g = 255, b = 255;
};

/// A font at one size, with the glyphs drawn so far. Text is UTF-8; characters that it lacks come from other fonts on
/// the machine (docs/film.md), and show as its empty box if none has them. Letters are set one beside the other, from
/// left to right: nothing joins or reorders them. Thread: one at a time.
class Font {
 public:
  enum class Weight { kBook, kBold };
  /// @param pixels  height of the em square
  [[nodiscard]] static Result<Font> open(Weight weight, int pixels);

  /// Width of `text` in pixels.
  [[nodiscard]] int width(std::string_view text);
  /// `text`, cut with an ellipsis where it is wider than `most` pixels.
  [[nodiscard]] std::string fitted(std::string_view text, int most);
  /// The same, cut on its left: the end of a path says most.
  [[nodiscard]] std::string fitted_end(std::string_view text, int most);
  /// Draws `text` with its base line at `base` and its left edge at `left`; clips at the edges of the picture.
  void draw(std::string_view text, int left, int base, Colour colour, Image& image);

 private:
  struct Glyph {
    int left = 0, top = 0, width = 0, height = 0, advance = 0;
    std::vector<std::uint8_t> coverage;
  };
  struct Face;  // FreeType's objects
  struct FaceDeleter {
    void operator()(Face* face) const;
  };

  Font() = default;
  const Glyph& glyph(char32_t character);

  std::unique_ptr<Face, FaceDeleter> face_;
  std::map<char32_t, Glyph> glyphs_;
};

/// Mixes `colour` into a rectangle, cut off at the edges of the picture. @param opacity  0 ... 255
void fill_rectangle(Image& image, int left, int top, int width, int height, Colour colour, int opacity);

}  // namespace takt::sim
