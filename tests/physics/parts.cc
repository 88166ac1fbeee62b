#include "tests/physics/parts.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

namespace takt::sim::test {

ObjectDescription part(const std::string& name, const ObjectShape& shape, double mass, const Eigen::Vector3d& at) {
  ObjectDescription object;
  object.name = name;
  object.shapes.push_back({.shape = shape});
  object.mount.X_P.translation() = at;
  object.free = true;
  object.mass = mass;
  return object;
}

ObjectDescription ground(const ContactParameters& surface) {
  ObjectDescription object;
  object.name = "ground";
  object.shapes.push_back({.shape = kinematics::Box{{40.0, 40.0, 1.0}}});
  object.mount.X_P.translation().z() = -0.5;
  object.contact = surface;
  return object;
}

Eigen::Vector3d gravity_on_slope(double angle) {
  return {kGravity * std::sin(angle), 0.0, -kGravity * std::cos(angle)};
}

ContactParameters with_friction(double friction) {
  ContactParameters surface;
  surface.friction = friction;
  return surface;
}

World built(const WorldDescription& description) {
  auto world = World::create(description);
  if (!world) throw std::runtime_error(world.error().to_string());
  return std::move(*world);
}

void run_for(World& world, double seconds) {
  const Nanoseconds end = world.time() + static_cast<Nanoseconds>(std::llround(1e9 * seconds));
  while (world.time() < end) ASSERT_TRUE(world.step()) << world.divergence();
}

Eigen::Vector3d place_of(const World& world, const std::string& body) {
  return world.body_pose(world.body(body)).translation();
}

Spin spin_of(const World& world, const std::string& body) {
  const mjModel& model = *world.physics_model();
  const int number = world.body(body);
  const double* velocity = world.physics_data()->qvel + model.body_dofadr[number];
  return {world.body_pose(number).linear(), Eigen::Map<const Eigen::Vector3d>(velocity + 3)};
}

}  // namespace takt::sim::test
