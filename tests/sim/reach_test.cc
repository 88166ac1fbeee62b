// What is left out of the search for contacts can never touch: no posture may lose a contact by it.
#include "sim/world/reach.h"

#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

using Pairs = std::set<std::pair<int, int>>;

/// An arm with a probe on a table, a post beside it, and a part that lies about.
WorldDescription cell(const std::string& arm, double height) {
  const auto read = device::read_arm("models/" + arm);
  if (!read) throw std::runtime_error(read.error().to_string());
  WorldDescription world;
  world.robots.push_back(arm_body("arm", **read, {"", Pose(Eigen::Translation3d(0.0, 0.0, height))}));
  RobotDescription probe = plain_body("probe", model("probe_ball"), {.parent = "arm/flange"});
  world.robots.push_back(probe);
  world.objects.push_back(box("floor", {6.0, 6.0, 0.1}, {0.0, 0.0, -0.06}));
  world.objects.push_back(box("table", {0.8, 1.0, 0.05}, {0.7, 0.0, height - 0.03}));
  world.objects.push_back(box("post", {0.1, 0.1, 1.5}, {-0.6, 0.5, 0.75}));
  world.objects.push_back(box("far", {0.1, 0.1, 1.0}, {4.0, 0.0, 0.5}));
  ObjectDescription part = box("part", {0.1, 0.1, 0.1}, {0.6, 0.3, height + 0.05});
  part.free = true;
  part.mass = 1.0;
  world.objects.push_back(part);
  return world;
}

/// Bodies in contact.
Pairs touching(const mjModel& model, mjData& data) {
  mj_kinematics(&model, &data);
  mj_comPos(&model, &data);
  mj_collision(&model, &data);
  Pairs pairs;
  for (int i = 0; i < data.ncon; ++i) {
    const int a = model.geom_bodyid[data.contact[i].geom[0]], b = model.geom_bodyid[data.contact[i].geom[1]];
    pairs.emplace(std::min(a, b), std::max(a, b));
  }
  return pairs;
}

class ReachTest : public testing::TestWithParam<std::tuple<std::string, double>> {};

TEST_P(ReachTest, NoPostureLosesAContact) {
  const auto& [arm, height] = GetParam();
  WorldDescription description = cell(arm, height);
  World less = make(description);
  description.physics.search_all_pairs = true;
  World all = make(description);
  const mjModel& a = *all.physics_model();
  const mjModel& b = *less.physics_model();
  EXPECT_GT(b.nexclude, a.nexclude) << "nothing was left out, so nothing is tested";
  mjData* data_a = mj_makeData(&a);
  mjData* data_b = mj_makeData(&b);
  std::mt19937 random(7);
  std::size_t contacts = 0;
  for (int i = 0; i < 20'000; ++i) {
    for (int joint = 0; joint < static_cast<int>(a.njnt); ++joint) {
      if (a.jnt_type[joint] != mjJNT_HINGE && a.jnt_type[joint] != mjJNT_SLIDE) continue;
      std::uniform_real_distribution<double> range(a.jnt_range[2 * joint], a.jnt_range[2 * joint + 1]);
      const int address = a.jnt_qposadr[joint];
      data_a->qpos[address] = data_b->qpos[address] = range(random);
    }
    const Pairs found = touching(a, *data_a);
    ASSERT_EQ(found, touching(b, *data_b)) << arm << " at " << height << " m, posture " << i;
    contacts += found.size();
  }
  EXPECT_GT(contacts, 100u) << "hardly any posture touches anything, so nothing is tested";
  mj_deleteData(data_a);
  mj_deleteData(data_b);
}

INSTANTIATE_TEST_SUITE_P(Arms, ReachTest,
                         testing::Combine(testing::Values("lwr4plus", "ur5", "tx90"), testing::Values(0.1, 0.8)));

TEST(Reach, WhatIsFarAwayIsLeftOut) {
  World world = make(cell("lwr4plus", 0.8));
  const mjModel& model = *world.physics_model();
  const int far = mj_name2id(&model, mjOBJ_BODY, "far"), part = mj_name2id(&model, mjOBJ_BODY, "part");
  int left_out = 0;
  for (int i = 0; i < model.nexclude; ++i) {
    const int a = model.exclude_signature[i] >> 16, b = model.exclude_signature[i] & 0xffff;
    left_out += a == far || b == far ? 1 : 0;
    EXPECT_TRUE(a != part && b != part) << "a part that moves freely may come to anything";
  }
  EXPECT_GE(left_out, 8) << "links of the arm, and the probe";
}

}  // namespace
}  // namespace takt::sim::test
