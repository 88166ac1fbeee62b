#pragma once

#include <array>

struct mjSpec_;

namespace takt::sim {

/// The look of a scene that no scenario has to describe. Colours are sRGB in 0..1.
struct StageOptions {
  double radius = 2.5;                         ///< m, around `centre`: what shall lie in the shadow map
  std::array<double, 3> centre = {0, 0, 0.6};  ///< m in world: what the lights and the free camera look at
  bool floor = true;                           ///< adds the plane z = `floor_height`
  bool floor_collides = true;                  ///< bodies rest on the floor; false: it is only drawn
  double floor_height = 0;                     ///< m in world
  std::array<float, 3> floor_colour = {0.62f, 0.65f, 0.69f};
  std::array<float, 3> sky_top = {0.48f, 0.58f, 0.71f};      ///< gradient of the sky, top ...
  std::array<float, 3> sky_horizon = {0.83f, 0.87f, 0.92f};  ///< ... and where it meets the floor
  std::array<double, 3> key_light = {-0.45, 0.55, -1.0};     ///< direction in which the shadow-casting light shines
};

/// Names of what add_scene_props adds; a scenario must not use them.
inline constexpr const char* kStageFloor = "stage_floor";
inline constexpr const char* kStageSky = "stage_sky";

/// Adds sky, floor, one key light with shadow, two fill lights, and clip planes sized to the scene. Leaves bodies,
/// geoms and materials of the scene alone. Call once, before the spec is compiled; physics sees only the floor.
/// @param spec  not null
/// Thread: the one that owns `spec`. Realtime: setup.
void add_scene_props(mjSpec_* spec, const StageOptions& options);

}  // namespace takt::sim
