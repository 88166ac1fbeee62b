// Contacts of the simulation against what an engineer computes by hand: depth under a load, sliding, a slope, a brake,
// a stack. Run from anywhere:
//   bench_contact        tables; docs/contacts.md, "Figures", explains them
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "sim/contact/contact_law.h"
#include "sim/world/world.h"

namespace {

using takt::sim::ContactParameters;
using takt::sim::ObjectDescription;
using takt::sim::ObjectShape;
using takt::sim::World;
using takt::sim::WorldDescription;

constexpr double kGravity = 9.81;
constexpr double kSize = 0.02;  // m, half of each part

World make(const WorldDescription& description) {
  auto world = World::create(description);
  if (world) return std::move(*world);
  std::fprintf(stderr, "%s\n", world.error().to_string().c_str());
  std::exit(2);
}

void run(World& world, int steps) {
  for (int i = 0; i < steps; ++i) {
    if (!world.step()) std::exit(3);
  }
}

ObjectDescription floor_of(double friction) {
  ObjectDescription floor;
  floor.name = "floor";
  floor.mount.X_P.translation().z() = -0.5;
  floor.shapes.push_back({.shape = takt::kinematics::Box{{20.0, 20.0, 1.0}}});
  floor.contact.friction = friction;
  return floor;
}

ObjectDescription part(const std::string& name, const ObjectShape& shape, double mass, double height,
                       double friction = 0.6) {
  ObjectDescription object;
  object.name = name;
  object.shapes.push_back({.shape = shape});
  object.mount.X_P.translation().z() = height;
  object.free = true;
  object.mass = mass;
  object.contact.friction = friction;
  return object;
}

ObjectShape box() { return takt::kinematics::Box{{2 * kSize, 2 * kSize, 2 * kSize}}; }
ObjectShape flat_box() { return takt::kinematics::Box{{2 * kSize, 2 * kSize, 0.5 * kSize}}; }

WorldDescription on_the_floor(const ObjectShape& shape, double mass, double height, double friction = 0.6) {
  WorldDescription description;
  description.objects.push_back(floor_of(friction));
  description.objects.push_back(part("part", shape, mass, height, friction));
  return description;
}

Eigen::Vector3d position(const World& world, const std::string& name = "part") {
  return world.body_pose(world.body(name)).translation();
}

void depths() {
  const double k = takt::sim::combine({}, {}, {}).stiffness;
  std::printf("\ndepth at rest over weight / stiffness (%.2g N/m)\n%-10s", k, "mass, kg");
  for (const char* name : {"sphere", "box", "cylinder"}) std::printf("%10s", name);
  for (const double mass : {0.001, 0.01, 0.1, 1.0, 10.0}) {
    std::printf("\n%-10g", mass);
    for (const ObjectShape& shape : {ObjectShape(takt::kinematics::Sphere{kSize}), box(),
                                     ObjectShape(takt::kinematics::Cylinder{kSize, 2 * kSize})}) {
      World world = make(on_the_floor(shape, mass, kSize));
      run(world, 3000);
      std::printf("%10.4f", (kSize - position(world).z()) * k / (mass * kGravity));
    }
  }
  std::printf("\n");
}

struct Slide {
  double mean = 0.0, deviation = 0.0, lost = 0.0, speed = 0.0;
};

/// A flat box pulled over the floor at a speed; forces over its weight.
Slide slide(double mass, double speed, double friction) {
  World world = make(on_the_floor(flat_box(), mass, 0.25 * kSize, friction));
  const std::size_t watch = *world.watch_contact("part", "floor");
  const int body = world.body("part");
  const double weight = mass * kGravity;
  run(world, 200);
  std::vector<double> forces;
  double moved = 0.0;
  Eigen::Vector3d before = position(world);
  for (int i = 0; i < 2500; ++i) {
    const double ramp = std::min(1.0, i / 300.0);
    // A drive with a loop of 100 rad/s on the speed.
    world.push(body, {friction * weight * ramp + mass * 100.0 * (speed * ramp - moved * 1000.0), 0.0, 0.0});
    run(world, 1);
    moved = position(world).x() - before.x();
    before = position(world);
    // The watch has the norm of normal and friction force.
    if (i >= 1000) forces.push_back(world.contact(watch).force / weight / std::hypot(1.0, friction));
  }
  Slide result;
  for (const double f : forces) {
    result.mean += f / static_cast<double>(forces.size());
    result.lost += f <= 0.0 ? 1.0 / static_cast<double>(forces.size()) : 0.0;
  }
  for (const double f : forces)
    result.deviation += (f - result.mean) * (f - result.mean) / static_cast<double>(forces.size());
  result.deviation = std::sqrt(result.deviation);
  result.speed = moved * 1000.0;
  return result;
}

void slides() {
  std::printf("\npulled over the floor: force over weight, spread, steps without contact, speed reached, mm/s\n");
  std::printf("%-10s%-10s%-10s%10s%10s%10s%10s\n", "mass, kg", "friction", "mm/s", "mean", "sd", "lost", "reached");
  for (const double mass : {0.001, 0.1, 10.0}) {
    for (const double friction : {0.3, 0.6}) {
      for (const double speed : {0.005, 0.02, 0.05, 0.1}) {
        const Slide s = slide(mass, speed, friction);
        std::printf("%-10g%-10g%-10g%10.4f%10.4f%9.1f%%%10.2f\n", mass, friction, 1000 * speed, s.mean, s.deviation,
                    100 * s.lost, 1000 * s.speed);
      }
    }
  }
}

void slope() {
  std::printf("\na box on a slope of 22 degrees, friction 0.6: creep in 20 s, um\n");
  for (const double mass : {0.001, 0.1, 10.0}) {
    WorldDescription description = on_the_floor(flat_box(), mass, 0.25 * kSize);
    const double angle = 22.0 * std::numbers::pi / 180.0;
    description.physics.gravity = {kGravity * std::sin(angle), 0.0, -kGravity * std::cos(angle)};
    World world = make(description);
    run(world, 500);
    const Eigen::Vector3d before = position(world);
    run(world, 20'000);
    std::printf("%-10g%10.5f\n", mass, 1e6 * (position(world) - before).norm());
  }
}

void stack() {
  WorldDescription description;
  description.objects.push_back(floor_of(0.6));
  for (int i = 0; i < 10; ++i)
    description.objects.push_back(part("part" + std::to_string(i), box(), 0.1, kSize * (2 * i + 1)));
  World world = make(description);
  run(world, 2000);
  std::vector<Eigen::Vector3d> before;
  for (int i = 0; i < 10; ++i) before.push_back(position(world, "part" + std::to_string(i)));
  run(world, 60'000);
  double moved = 0.0;
  for (int i = 0; i < 10; ++i) {
    moved = std::max(moved, (position(world, "part" + std::to_string(i)) - before[static_cast<std::size_t>(i)]).norm());
  }
  std::printf("\na stack of ten boxes, 60 s: moved by at most %.6f um\n", 1e6 * moved);
}

}  // namespace

int main() {
  depths();
  slides();
  slope();
  stack();
  return 0;
}
