#pragma once

#include <array>
#include <variant>

namespace takt::sim {

/// A camera that stands free in the room.
struct FreeCamera {
  std::array<double, 3> look_at = {0, 0, 0.5};  ///< m in world
  double distance = 3;                          ///< m from look_at
  double azimuth = 135;                         ///< degrees about world z
  double elevation = -25;                       ///< degrees; negative looks down

  [[nodiscard]] bool operator==(const FreeCamera&) const = default;
};

/// A camera of the model by its index, or a free one.
using CameraView = std::variant<int, FreeCamera>;

}  // namespace takt::sim
