#pragma once

#include <string>

#include <Eigen/Geometry>

#include "sim/world/world.h"

namespace takt::sim::test {

inline constexpr double kGravity = 9.81;

/// A free object of one shape; its frame is in the middle of the shape.
[[nodiscard]] ObjectDescription part(const std::string& name, const ObjectShape& shape, double mass,
                                     const Eigen::Vector3d& at);
/// A box fixed to the world whose upper face is z = 0.
[[nodiscard]] ObjectDescription ground(const ContactParameters& surface = {});
/// Gravity of a slope: the world is turned instead of the ground, so that z is normal to it and x points down.
[[nodiscard]] Eigen::Vector3d gravity_on_slope(double angle);
[[nodiscard]] ContactParameters with_friction(double friction);

/// The world, or a failure of the test with all diagnostics.
[[nodiscard]] World built(const WorldDescription& description);
/// Steps; fails the test if the physics diverges.
void run_for(World& world, double seconds);
[[nodiscard]] Eigen::Vector3d place_of(const World& world, const std::string& body);

/// Rotation of a free object, from the state of the physics.
struct Spin {
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< rad/s, in the axes of the body
};
[[nodiscard]] Spin spin_of(const World& world, const std::string& body);

}  // namespace takt::sim::test
