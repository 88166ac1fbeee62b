#pragma once

#include <array>
#include <vector>

namespace takt::sim {

/// A shape that a picture shows beside the scene: part of a path, a beam, a force, an axis of a frame.
struct Mark {
  enum class Shape { kRod, kArrow };
  Shape shape = Shape::kRod;
  std::array<float, 3> from{}, to{};  ///< m in world; an arrow's tip is at `to`
  float radius = 0.003F;              ///< m; of an arrow: of its shaft
  std::array<float, 4> rgba{1, 1, 1, 1};
  bool on_top = false;  ///< drawn over whatever would hide it
  bool operator==(const Mark&) const = default;
};

/// Bodies once more, translucent, at other positions: where machines are commanded to be.
struct Ghost {
  std::vector<double> qpos;  ///< as in the model; empty: there is none
  std::vector<bool> bodies;  ///< by number: those that are shown
  bool operator==(const Ghost&) const = default;
};

/// What a picture shows beside the scene.
struct Marks {
  std::vector<Mark> shapes;
  Ghost ghost;
  bool operator==(const Marks&) const = default;
};

}  // namespace takt::sim
