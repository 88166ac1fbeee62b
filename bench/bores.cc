// What a step of the physics costs where parts are in bores: pegs, screws in a rack and in a thread, a drilled plate.
// Run from anywhere:
//   bench_bores          one line per world: least and median of blocks of 100 steps, and how many contacts there are
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "sim/world/world.h"

namespace {

using takt::kinematics::Box;
using takt::kinematics::Cylinder;
using takt::sim::ObjectDescription;
using takt::sim::World;
using takt::sim::WorldDescription;

constexpr int kBlock = 100;
constexpr int kBlocks = 60;

// M6: ISO 724, ISO 273 (medium), ISO 4762.
constexpr double kMajor = 0.006, kMinor = 0.004917, kPitchDiameter = 0.00535, kPitch = 0.001, kClearance = 0.0066;
constexpr double kHead = 0.01, kHeadHeight = 0.006, kSocket = 0.00575, kSocketDepth = 0.003, kShank = 0.012;
constexpr double kChamfer = 0.6 * (kMajor - kMinor);

ObjectDescription block(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& middle) {
  ObjectDescription object;
  object.name = name;
  object.mount.X_P.translation() = middle;
  object.shapes.push_back({.shape = Box{size}});
  return object;
}

void drill(ObjectDescription& object, double x, double y, takt::world::Bore bore) {
  bore.X_SB.translation() = Eigen::Vector3d(x, y, 0.5 * std::get<Box>(object.shapes[0].shape).size.z());
  object.shapes[0].bores.push_back(std::move(bore));
}

ObjectDescription screw(const std::string& name, const Eigen::Vector3d& tip) {
  ObjectDescription object;
  object.name = name;
  object.free = true;
  object.mass = 0.006;
  object.mount.X_P.translation() = tip;
  object.shapes.push_back({.shape = Cylinder{0.5 * kMajor, kShank}, .chamfer = kChamfer});
  object.shapes.push_back({.shape = Cylinder{0.5 * kHead, kHeadHeight}});
  object.shapes[0].X_OG.translation().z() = 0.5 * kShank;
  object.shapes[1].X_OG.translation().z() = kShank + 0.5 * kHeadHeight;
  takt::world::Bore socket{.radius = 0.5 * kSocket, .depth = kSocketDepth};
  socket.X_SB.translation().z() = 0.5 * kHeadHeight;
  object.shapes[1].bores.push_back(socket);
  object.screw = takt::sim::ScrewDescription{.thread = {"M6", kPitch, kMajor, kPitchDiameter, 0.06, 0.12}};
  return object;
}

/// As in a cell with screws: some in a rack, a plate with their threads.
WorldDescription rack(int screws) {
  WorldDescription world;
  world.physics.timestep = takt::kMillisecond / 2;
  const double length = 0.04 * screws + 0.02;
  ObjectDescription plate = block("plate", {0.1, length, 0.03}, {0.2, 0.0, 0.015});
  ObjectDescription holder = block("rack", {0.05, length, 0.03}, {0.0, 0.0, 0.015});
  for (int i = 0; i < screws; ++i) {
    const double y = 0.04 * (i - 0.5 * (screws - 1));
    drill(plate, 0.0, y, {.radius = 0.5 * kMinor, .depth = 0.02, .chamfer = kChamfer, .thread = "M6"});
    drill(holder, 0.0, y, {.radius = 0.5 * kClearance, .chamfer = 0.001});
    // A little beside the axis, so that the shank touches the wall at times.
    world.objects.push_back(screw("screw" + std::to_string(i), {0.0002, y + 0.0001 * i, 0.03 - kShank + 1e-4}));
  }
  world.objects.push_back(plate);
  world.objects.push_back(holder);
  return world;
}

WorldDescription thread() {
  WorldDescription world;
  world.physics.timestep = takt::kMillisecond / 2;
  ObjectDescription plate = block("plate", {0.1, 0.1, 0.03}, {0.0, 0.0, -0.015});
  drill(plate, 0.0, 0.0, {.radius = 0.5 * kMinor, .depth = 0.02, .chamfer = kChamfer, .thread = "M6"});
  world.objects.push_back(screw("screw", {0.0, 0.0, -kChamfer}));
  world.objects.push_back(plate);
  return world;
}

/// A peg of 30 mm in its bore, with as many more bores in the block around it.
WorldDescription peg(int others) {
  WorldDescription world;
  ObjectDescription plate = block("plate", {0.4, 0.4, 0.05}, {0.0, 0.0, -0.025});
  drill(plate, 0.0, 0.0, {.radius = 0.01515, .depth = 0.04, .chamfer = 0.001});
  for (int i = 0; i < others; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / others;
    drill(plate, 0.1 * std::cos(angle), 0.1 * std::sin(angle), {.radius = 0.01515, .depth = 0.04, .chamfer = 0.001});
  }
  ObjectDescription part;
  part.name = "peg";
  part.free = true;
  part.mass = 0.3;
  part.mount.X_P.translation().z() = -0.01;
  part.shapes.push_back({.shape = Cylinder{0.015, 0.06}, .chamfer = 0.001});
  world.objects.push_back(plate);
  world.objects.push_back(part);
  return world;
}

/// @param push  before each step, by its number
void measure(const std::string& name, WorldDescription description, const std::function<void(World&, int)>& push = {}) {
  description.physics.rest = false;  // what sleeps has no contacts to measure
  auto world = World::create(description);
  if (!world) {
    std::fprintf(stderr, "%s\n", world.error().to_string().c_str());
    std::exit(2);
  }
  int step = 0;
  std::size_t contacts = 0;
  const auto run = [&] {
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < kBlock; ++k, ++step) {
      if (push) push(*world, step);
      if (!world->step()) std::exit(3);
      contacts += static_cast<std::size_t>(world->physics_data()->ncon);
    }
    const double cycles = kBlock * static_cast<double>(description.physics.period / description.physics.timestep);
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count() / cycles;
  };
  run();
  contacts = 0;
  std::vector<double> costs;
  for (int i = 0; i < kBlocks; ++i) costs.push_back(run());
  std::ranges::sort(costs);
  std::printf("%-40s %8.2f us least %8.2f us median %6.1f contacts\n", name.c_str(), costs.front(),
              costs[costs.size() / 2], static_cast<double>(contacts) / (kBlock * kBlocks));
}

}  // namespace

int main() {
  std::printf("one step of the physics\n");
  measure("three screws in a rack", rack(3));
  measure("nine screws in a rack", rack(9));
  measure("a screw that turns in its thread", thread(), [](World& world, int) {
    auto* data = const_cast<mjData*>(world.physics_data());
    const int dof = world.physics_model()->body_dofadr[world.body("screw")];
    data->qfrc_applied[dof + 5] = data->qvel[dof + 5] > -1.0 ? -0.08 : 0.0;
  });
  const auto around = [](World& world, int step) {
    const double angle = 0.002 * step;
    world.push(world.body("peg"), {20.0 * std::cos(angle), 20.0 * std::sin(angle), -5.0});
  };
  measure("a peg pressed round the wall of its bore", peg(0), around);
  measure("the same in a block with nine bores", peg(8), around);
  return 0;
}
