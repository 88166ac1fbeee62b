#pragma once

#include <array>
#include <cstdint>
#include <vector>

struct mjModel_;

namespace takt::sim {

/// What is drawn of one geom, as triangles in the frame of its body: for viewers that know the poses of bodies only.
struct BodyShape {
  int body = 0;                              ///< number; 0: the world
  std::array<float, 4> rgba{};               ///< sRGB and opacity, 0 to 1
  std::vector<std::array<float, 3>> points;  ///< m
  std::vector<std::uint32_t> indices;        ///< three per triangle
};

/// All that a film draws of the model but floors without end. May throw MujocoError. Realtime: setup.
[[nodiscard]] std::vector<BodyShape> body_shapes(const mjModel_* model);

}  // namespace takt::sim
