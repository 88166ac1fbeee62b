// Cost of one control cycle of a simulated LWR 4+ with force/torque sensor, probe, table and block: the share of the
// touch scenario that the simulation has. Run from the repository root:
//   bench_sim            one line per variant: least and median of blocks of 200 cycles
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "sim/world/world.h"

namespace {

using takt::kinematics::RobotModel;
using takt::sim::Integrator;
using takt::sim::JointVector;
using takt::sim::RobotDescription;
using takt::sim::World;
using takt::sim::WorldDescription;

// Short blocks: on a busy machine most of them run undisturbed, and the least of them is the cost.
constexpr int kBlock = 200;
constexpr int kBlocks = 300;

JointVector home() { return (JointVector(7) << 0, -0.5236, 0, 1.5708, 0, -1.0472, 0).finished(); }

RobotDescription robot(const std::string& name, const std::string& folder, const std::string& parent) {
  auto model = RobotModel::load("models/" + folder + "/" + folder + ".urdf");
  if (!model) {
    std::fprintf(stderr, "%s\n", model.error().to_string().c_str());
    std::exit(2);
  }
  RobotDescription made;
  made.name = name;
  made.model = std::make_shared<RobotModel>(std::move(*model));
  made.mount.parent = parent;
  return made;
}

takt::sim::ObjectDescription box(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& at) {
  takt::sim::ObjectDescription object;
  object.name = name;
  object.mount.X_P.translation() = at;
  object.shapes.push_back({.shape = takt::kinematics::Box{size}});
  return object;
}

/// @param depth  how far the block reaches into the ball of the probe at home; negative: no contact
WorldDescription touch_cell(double depth) {
  WorldDescription world;
  world.robots.push_back(robot("arm", "lwr4plus", ""));
  world.robots[0].mount.X_P.translation().z() = 0.0;
  const JointVector q = home();
  world.robots[0].q.assign(q.begin(), q.end());
  for (int i = 0; i < 7; ++i) {
    const std::vector<std::string> names = {"a1", "a2", "e1", "a3", "a4", "a5", "a6"};
    world.robots[0].joints.push_back({.joint = names[static_cast<std::size_t>(i)], .armature = i < 4 ? 1.0 : 0.3});
  }
  world.robots.push_back(robot("sensor", "ft_gamma", "arm/flange"));
  world.robots.push_back(robot("probe", "probe_ball", "sensor/tool"));
  takt::sim::SimArmDescription arm;
  arm.name = arm.robot = "arm";
  arm.base_link = "base";
  arm.flange_link = "flange";
  arm.measurement.position_resolution = 1e-6;
  arm.measurement.velocity_noise = 1e-4;
  arm.measurement.torque_noise = JointVector::Constant(7, 0.1);
  world.arms.push_back(arm);
  takt::sim::SimForceTorqueDescription wrist;
  wrist.name = "wrist";
  wrist.tool_side = "sensor/measuring";
  wrist.force_noise.setConstant(0.05);
  wrist.torque_noise.setConstant(0.001);
  world.force_torque_sensors.push_back(wrist);
  world.objects.push_back(box("table", {0.8, 1.0, 0.05}, {0.6, 0, 0.05}));
  auto empty = World::create(world);
  const Eigen::Vector3d ball = empty->body_pose(empty->body("probe/tcp")).translation();
  world.objects.push_back(box("block", {0.12, 0.08, 0.06}, ball - Eigen::Vector3d(0, 0, 0.035 - depth)));
  return world;
}

void measure(const std::string& name, const WorldDescription& description) {
  auto world = World::create(description);
  if (!world) {
    std::fprintf(stderr, "%s\n", world.error().to_string().c_str());
    std::exit(2);
  }
  takt::device::ArmSetPoint point;
  point.q = home();
  point.dq = point.ddq = JointVector::Zero(7);
  const auto run = [&](int cycles) {
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < cycles; ++k) {
      world->arm("arm")->write(point);
      if (!world->step()) std::exit(3);
    }
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count() / cycles;
  };
  run(kBlock);
  std::vector<double> costs;
  for (int i = 0; i < kBlocks; ++i) costs.push_back(run(kBlock));
  std::ranges::sort(costs);
  world->set_profiling(true);
  takt::Nanoseconds physics = takt::kSecond, devices = takt::kSecond;  // least of a block
  for (int i = 0; i < kBlocks; ++i) {
    const auto before = world->times();
    run(kBlock);
    physics = std::min(physics, world->times().physics - before.physics);
    devices = std::min(devices, world->times().devices - before.devices);
  }
  std::printf("%-28s %6.2f us least %6.2f us median  (least: physics %5.2f, devices and state %5.2f)\n", name.c_str(),
              costs.front(), costs[costs.size() / 2], 1e-3 * static_cast<double>(physics) / kBlock,
              1e-3 * static_cast<double>(devices) / kBlock);
}

}  // namespace

int main() {
  std::printf("one cycle of 1 ms: LWR 4+, force/torque sensor, probe, table, block\n");
  WorldDescription apart = touch_cell(-0.01);
  WorldDescription touching = touch_cell(0.0005);
  measure("free", apart);
  measure("touching", touching);
  // What the observer of external torques and the noise of the torque sensors cost.
  apart.arms[0].measurement.torque_sensors = false;
  measure("free, no torque sensors", apart);
  apart.arms[0].measurement.torque_sensors = true;
  apart.robots[0].self_collision = true;
  measure("free, may touch itself", apart);
  apart.robots[0].self_collision = false;
  apart.physics.integrator = Integrator::kImplicitFast;
  measure("free, implicitfast", apart);
  apart.physics.integrator = Integrator::kEuler;
  apart.physics.timestep = takt::kMillisecond / 2;
  measure("free, two physics steps", apart);
  return 0;
}
