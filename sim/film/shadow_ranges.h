#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace takt::sim {

/// Side of a block of a shadow map, texels, and how far around it the filter of a shadow's edge may reach.
inline constexpr int kShadowBlock = 4, kShadowReach = 2;
/// The depth that stands for "nothing there": farther than any surface.
inline constexpr float kNoCaster = 2.0f;

/// What a picture has to know of a block before it looks into the shadow map itself: most pixels are in front of all
/// that is near them in the map, or behind all of it (docs/film.md, "Speed").
struct ShadowRange {
  float least = kNoCaster, greatest = kNoCaster;  ///< depths of the block and of kShadowReach texels around it
  float edge = 0;  ///< 1: they are so far apart that a shadow's edge runs through, which is worth a wide filter
  float unused = 0;
};

/// Turns a depth map into ranges. Owns what it needs between two maps. Thread: one at a time. Realtime: setup.
class ShadowRanges {
 public:
  /// @param depth  `size` x `size` depths, 65535: nothing there; `size` is a multiple of kShadowBlock
  /// @param edge  difference of depths, as a share of the whole range, from which on it is an edge
  /// @return (size / kShadowBlock)^2 ranges, row by row, until the next call
  const std::vector<ShadowRange>& of(std::span<const std::uint16_t> depth, int size, float edge);

 private:
  std::vector<std::uint16_t> least_, greatest_;  ///< of 2x2 texels
  std::vector<std::uint16_t> row_least_, row_greatest_;
  std::vector<ShadowRange> ranges_;
};

}  // namespace takt::sim
