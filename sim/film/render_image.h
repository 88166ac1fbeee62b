#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::sim {

/// A picture: `height` rows of `width` pixels from the top, 4 bytes each (red, green, blue, unused = 255), no padding.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;

  void resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    rgba.resize(static_cast<std::size_t>(4) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  [[nodiscard]] std::uint8_t* pixel(int x, int y) {
    return rgba.data() + 4 * (static_cast<std::size_t>(y) * width + x);
  }
  [[nodiscard]] const std::uint8_t* pixel(int x, int y) const {
    return rgba.data() + 4 * (static_cast<std::size_t>(y) * width + x);
  }
  bool operator==(const Image&) const = default;
};

/// Smooths the stair steps of edges and leaves flat areas untouched; the outermost pixels stay. What comes out depends
/// on the picture alone; the object only keeps memory from one picture to the next. Thread: one at a time.
class EdgeSmoother {
 public:
  void smooth(Image& image);

 private:
  struct Change {
    std::uint32_t pixel;
    std::array<std::uint8_t, 3> rgb;
  };
  std::vector<std::uint8_t> luma_, edges_;
  std::vector<Change> changes_;
};

/// Writes binary PPM (P6); a path that cannot be written is a diagnostic. Realtime: setup.
[[nodiscard]] Result<void> write_ppm(const Image& image, const std::filesystem::path& path);

/// The bytes of a PNG file. Same picture: same bytes, by the same library. Realtime: setup.
/// @param fast  packed less well in less time, for pictures that are looked at once
[[nodiscard]] Result<std::string> png_of(const Image& image, bool fast = false);

/// Writes PNG; a path that cannot be written is a diagnostic. Realtime: setup.
[[nodiscard]] Result<void> write_png(const Image& image, const std::filesystem::path& path);

/// Copies `source` into `target` with its upper left corner at (left, top), inside a frame of `border` pixels; what
/// hangs over is cut off.
void paste(const Image& source, Image& target, int left, int top, int border);

}  // namespace takt::sim
