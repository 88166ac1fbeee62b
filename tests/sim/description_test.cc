// What is wrong in a description is said before anything moves: all at once, each at its place.
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

WorldDescription described_cell() {
  WorldDescription world;
  world.robots.push_back(lwr());
  add_probe(world);
  world.arms.push_back(lwr_controller());
  world.objects.push_back(box("table", {1, 1, 0.1}, {0.6, 0, -0.05}));
  return world;
}

std::string diagnostics(const WorldDescription& description) {
  const auto world = World::create(description);
  return world ? std::string() : world.error().to_string();
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Description, GoodOneHasNoFindings) { EXPECT_EQ(diagnostics(described_cell()), ""); }

TEST(Description, AllErrorsAtOnceEachAtItsPlace) {
  WorldDescription world = described_cell();
  world.robots[1].mount.parent = "arm/flanch";
  world.robots[0].pointer = "/cell/devices/arm";
  world.robots[0].joints[0].joint = "a8";
  world.objects.push_back(box("table", {1, 1, -1}, {0, 0, 0}));
  world.force_torque_sensors[0].tool_side = "sensor/mesuring";
  world.arms.push_back(world.arms[0]);
  const std::string text = diagnostics(world);
  EXPECT_TRUE(contains(text, "/robots/sensor: error: unknown parent 'arm/flanch'")) << text;
  EXPECT_TRUE(contains(text, "arm/flange")) << text;
  EXPECT_TRUE(contains(text, "/cell/devices/arm: error: unknown joint 'a8'")) << text;
  EXPECT_TRUE(contains(text, "the name 'table' is taken")) << text;
  EXPECT_TRUE(contains(text, "not > 0")) << text;
  EXPECT_TRUE(contains(text, "unknown tool side 'sensor/mesuring'")) << text;
  EXPECT_TRUE(contains(text, "driven by 'arm' already")) << text;
}

TEST(Description, MountLoopIsFound) {
  WorldDescription world = described_cell();
  world.objects.push_back(box("a", {1, 1, 1}, {0, 0, 0}));
  world.objects.push_back(box("b", {1, 1, 1}, {0, 0, 0}));
  world.objects[1].mount.parent = "b";
  world.objects[2].mount.parent = "a";
  EXPECT_TRUE(contains(diagnostics(world), "in a loop"));
  world.objects[2].mount.parent = "b";
  EXPECT_TRUE(contains(diagnostics(world), "'b' is mounted on itself"));
}

TEST(Description, FiguresOutOfRange) {
  const auto broken = [](auto change) {
    WorldDescription world = described_cell();
    change(world);
    return diagnostics(world);
  };
  EXPECT_TRUE(contains(broken([](auto& w) { w.physics.timestep = 300'000; }), "whole physics steps"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.robots[0].q[1] = 3.0; }), "the start position of joint 'a2' is 3"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.robots[0].q.pop_back(); }), "6 start positions for 7"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.objects[0].contact.stiffness = 0.0; }), "N/m"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.objects[0].free = true; }), "mass of a free object"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.arms[0].flange_link = "flunge"; }), "flunge"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.arms[0].control.damping_ratio = JointVector::Ones(3); }), "3 figures"));
  EXPECT_TRUE(contains(broken([](auto& w) { w.force_torque_sensors[0].period = 1'500'000; }), "sensor period"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(contains(broken([&](auto& w) { w.objects[0].mount.X_P.translation().x() = nan; }), "not finite"));
  EXPECT_TRUE(contains(broken([&](auto& w) { w.objects[0].contact.friction = nan; }), "friction is nan"));
}

TEST(Description, WhatMujocoRefusesIsAFinding) {
  WorldDescription world = described_cell();
  const auto path = std::filesystem::path(testing::TempDir()) / "takt_broken_mesh.stl";
  std::ofstream(path) << "no mesh at all";
  kinematics::Mesh mesh;
  mesh.path = path;
  world.objects[0].shapes.push_back({.shape = mesh});
  const std::string text = diagnostics(world);
  EXPECT_TRUE(contains(text, "MuJoCo")) << text;
  EXPECT_TRUE(contains(text, "takt_broken_mesh")) << text;
  std::filesystem::remove(path);
}

TEST(Description, FreeObjectFallsOntoAFixedOneAndRests) {
  WorldDescription world = described_cell();
  ObjectDescription part = box("part", {0.05, 0.05, 0.05}, {0.6, 0, 0.2});
  part.free = true;
  part.mass = 0.5;
  world.objects.push_back(part);
  World made = make(world);
  const std::size_t watch = *made.watch_contact("part", "table");
  for (int k = 0; k < 1500; ++k) ASSERT_TRUE(made.step());
  EXPECT_NEAR(made.body_pose(made.body("part")).translation().z(), 0.025, 1e-4);
  EXPECT_NEAR(made.contact(watch).force, 0.5 * 9.81, 0.01);
  EXPECT_GT(made.contact(watch).contacts, 2);
}

TEST(Description, DivergedPhysicsIsToldAndNotRestarted) {
  WorldDescription world = described_cell();
  world.arms.clear();
  world.robots.resize(1);
  world.force_torque_sensors.clear();
  // Without rotors and with stops of no width the light wrist is torn apart by a gravity that no step can follow.
  for (auto& joint : world.robots[0].joints) joint.armature = 0.0;
  world.physics.gravity << 0, 0, -1e13;
  World made = make(world);
  bool alive = true;
  for (int k = 0; k < 1000 && alive; ++k) alive = made.step();
  EXPECT_FALSE(alive);
}

TEST(Description, UnknownSidesOfAContactAreFindings) {
  World world = make(described_cell());
  const auto watch = world.watch_contact("proob", "tabel");
  ASSERT_FALSE(watch);
  EXPECT_TRUE(contains(watch.error().to_string(), "proob"));
  EXPECT_TRUE(contains(watch.error().to_string(), "table"));
}

TEST(Description, CamerasLookWhereTheyAreTold) {
  WorldDescription world = described_cell();
  CameraDescription camera;
  camera.name = "front";
  camera.mount.X_P = look_at({2, 0, 1}, {0, 0, 1});
  world.cameras.push_back(camera);
  const World made = make(world);
  const int id = mj_name2id(made.physics_model(), mjOBJ_CAMERA, "front");
  ASSERT_GE(id, 0);
  const double* R = made.physics_data()->cam_xmat + 9 * id;  // row-major, columns: right, up, back
  EXPECT_NEAR(R[2], 1.0, 1e-12);
  EXPECT_NEAR(R[7], 1.0, 1e-12);
}

}  // namespace
}  // namespace takt::sim::test
