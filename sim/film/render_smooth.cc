#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "sim/film/render_image.h"

// GCC leaves the row loops scalar at -O2.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize("O3")
#endif

namespace takt::sim {
namespace {

constexpr int kContrast = 14;  // in 1/255: less is no edge that an eye would see
constexpr int kReach = 10;     // pixels that an edge is followed to either side

// Brightness of every pixel, 0 to 255: a quarter red, half green, a quarter blue.
void brightness(const Image& image, std::vector<std::uint8_t>& luma) {
  const std::size_t count = image.rgba.size() / 4;
  luma.resize(count);
  const std::uint8_t* in = image.rgba.data();
  std::uint8_t* out = luma.data();
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t pixel = 0;
    std::memcpy(&pixel, in + 4 * i, 4);
    out[i] = static_cast<std::uint8_t>(((pixel & 0xff) + ((pixel >> 7) & 0x1fe) + ((pixel >> 16) & 0xff)) >> 2);
  }
}

// Marks in `edges` where a row differs from its four neighbours.
void find_edges(const std::uint8_t* luma, int width, std::uint8_t* edges) {
  const std::uint8_t* above = luma - width;
  const std::uint8_t* below = luma + width;
  for (int x = 1; x < width - 1; ++x) {
    const std::uint8_t high = std::max({luma[x], above[x], below[x], luma[x - 1], luma[x + 1]});
    const std::uint8_t low = std::min({luma[x], above[x], below[x], luma[x - 1], luma[x + 1]});
    edges[x] = static_cast<std::uint8_t>(high - low) > kContrast ? 1 : 0;
  }
}

// How much of the neighbour across the edge belongs into the pixel, in 1/256, and where that neighbour lies.
struct Blend {
  std::ptrdiff_t across = 0;
  int weight = 0;
};

// A slanted edge is a stair; the pixel's share of the other side falls linearly from the step to the middle of the
// tread. So: find the two ends of the tread, and blend by the distance to the nearer one, if that end steps our way.
Blend blend_at(const std::vector<std::uint8_t>& luma, int width, int height, int x, int y) {
  const std::ptrdiff_t row = width;
  const std::uint8_t* p = luma.data() + y * row + x;
  const int here = p[0];
  const int curve_x = std::abs(p[-1] + p[1] - 2 * here) * 2 + std::abs(p[-row - 1] + p[-row + 1] - 2 * p[-row]) +
                      std::abs(p[row - 1] + p[row + 1] - 2 * p[row]);
  const int curve_y = std::abs(p[-row] + p[row] - 2 * here) * 2 + std::abs(p[-row - 1] + p[row - 1] - 2 * p[-1]) +
                      std::abs(p[-row + 1] + p[row + 1] - 2 * p[1]);
  const bool level = curve_y >= curve_x;  // the edge runs along x
  const std::ptrdiff_t along = level ? 1 : row;
  const std::ptrdiff_t side = level ? row : 1;
  const int rise_back = std::abs(p[-side] - here), rise_on = std::abs(p[side] - here);
  const std::ptrdiff_t across = rise_back >= rise_on ? -side : side;
  const int rise = std::max(rise_back, rise_on);
  if (rise <= kContrast / 2) return {};
  const int middle = here + p[across];  // twice the brightness on the edge

  const int room_back = level ? x : y;
  const int room_on = (level ? width : height) - 1 - room_back;
  const auto walk = [&](std::ptrdiff_t step, int room, int& deviation) {
    int length = 1;
    for (const int most = std::min(kReach, room); length <= most; ++length) {
      deviation = p[length * step] + p[length * step + across] - middle;
      if (2 * std::abs(deviation) >= rise) break;
    }
    return length;
  };
  int deviation_back = 0, deviation_on = 0;
  const int back = walk(-along, room_back, deviation_back);
  const int on = walk(along, room_on, deviation_on);
  const int nearer = std::min(back, on);
  const int deviation = back < on ? deviation_back : deviation_on;
  if (2 * std::abs(deviation) < rise) return {};  // no end in reach: a straight edge
  // The near end must step towards the other side, else this pixel lies on the far half of the tread.
  if ((deviation > 0) == (2 * here - middle > 0)) return {};
  return {across, 128 - 256 * nearer / (back + on)};
}

}  // namespace

void EdgeSmoother::smooth(Image& image) {
  if (image.width < 3 || image.height < 3) return;
  brightness(image, luma_);
  edges_.resize(static_cast<std::size_t>(image.width));
  changes_.clear();
  const std::ptrdiff_t row = image.width;
  for (int y = 1; y < image.height - 1; ++y) {
    find_edges(luma_.data() + y * row, image.width, edges_.data());
    for (int x = 1; x < image.width - 1; ++x) {
      if (edges_[static_cast<std::size_t>(x)] == 0) continue;
      const Blend blend = blend_at(luma_, image.width, image.height, x, y);
      if (blend.weight <= 0) continue;
      const std::uint8_t* here = image.pixel(x, y);
      const std::uint8_t* other = here + 4 * blend.across;
      Change change{static_cast<std::uint32_t>(y * row + x), {}};
      for (std::size_t c = 0; c < 3; ++c)
        change.rgb[c] = static_cast<std::uint8_t>(here[c] + (((other[c] - here[c]) * blend.weight + 128) >> 8));
      changes_.push_back(change);
    }
  }
  for (const Change& change : changes_)
    std::memcpy(image.rgba.data() + 4 * std::size_t{change.pixel}, change.rgb.data(), 3);
}

}  // namespace takt::sim

// What follows in a batch of files keeps its own level.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
