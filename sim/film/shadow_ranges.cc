#include "sim/film/shadow_ranges.h"

#include <algorithm>
#include <limits>

// GCC leaves the row loops scalar at -O2.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize("O3")
#endif

namespace takt::sim {
namespace {

constexpr std::uint16_t kFar = std::numeric_limits<std::uint16_t>::max();

void halve(const std::uint16_t* upper, const std::uint16_t* lower, std::size_t half, std::uint16_t* least,
           std::uint16_t* greatest) {
  for (std::size_t i = 0; i < half; ++i) {
    const std::uint16_t a = upper[2 * i], b = upper[2 * i + 1], c = lower[2 * i], d = lower[2 * i + 1];
    least[i] = std::min(std::min(a, b), std::min(c, d));
    greatest[i] = std::max(std::max(a, b), std::max(c, d));
  }
}

void widen(const std::uint16_t* least_in, const std::uint16_t* greatest_in, std::size_t count, std::uint16_t* least,
           std::uint16_t* greatest) {
  for (std::size_t i = 0; i < count; ++i) {
    least[i] = std::min(least[i], least_in[i]);
    greatest[i] = std::max(greatest[i], greatest_in[i]);
  }
}

/// Half a step of the map nearer or farther, so that no rounding of a depth decides.
ShadowRange range_of(std::uint16_t least, std::uint16_t greatest, float edge) {
  constexpr float kScale = 1.0f / static_cast<float>(kFar);
  const float a = least == kFar ? kNoCaster : (static_cast<float>(least) - 1) * kScale;
  const float b = greatest == kFar ? kNoCaster : (static_cast<float>(greatest) + 1) * kScale;
  return {.least = a, .greatest = b, .edge = b - a > edge ? 1.0f : 0.0f};
}

}  // namespace

const std::vector<ShadowRange>& ShadowRanges::of(std::span<const std::uint16_t> depth, int size, float edge) {
  static_assert(kShadowBlock == 4 && kShadowReach == 2, "a block is two halves wide and reaches one further");
  const auto width = static_cast<std::size_t>(size), half = width / 2, blocks = width / kShadowBlock;
  least_.resize(half * half);
  greatest_.resize(half * half);
  for (std::size_t row = 0; row < half; ++row) {
    const std::uint16_t* upper = depth.data() + 2 * row * width;
    halve(upper, upper + width, half, least_.data() + row * half, greatest_.data() + row * half);
  }
  ranges_.resize(blocks * blocks);
  // One more on both sides: beyond the map nothing casts a shadow.
  row_least_.resize(half + 2);
  row_greatest_.resize(half + 2);
  for (std::size_t block_row = 0; block_row < blocks; ++block_row) {
    const std::size_t first = 2 * block_row > 0 ? 2 * block_row - 1 : 0, last = std::min(half - 1, 2 * block_row + 2);
    const bool at_border = block_row == 0 || block_row + 1 == blocks;
    std::ranges::fill(row_least_, kFar);
    std::ranges::fill(row_greatest_, at_border ? kFar : std::uint16_t{0});
    row_greatest_.front() = row_greatest_.back() = kFar;
    for (std::size_t row = first; row <= last; ++row)
      widen(least_.data() + row * half, greatest_.data() + row * half, half, row_least_.data() + 1,
            row_greatest_.data() + 1);
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::uint16_t* low = row_least_.data() + 2 * block;
      const std::uint16_t* high = row_greatest_.data() + 2 * block;
      ranges_[block_row * blocks + block] =
          range_of(std::min(std::min(low[0], low[1]), std::min(low[2], low[3])),
                   std::max(std::max(high[0], high[1]), std::max(high[2], high[3])), edge);
    }
  }
  return ranges_;
}

}  // namespace takt::sim

// What follows in a batch of files keeps its own level.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
