#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "core/expression/cell.h"
#include "core/kinematics/chain.h"
#include "core/rcc/control_core.h"
#include "tests/support/fake_arm.h"
#include "tests/support/guarded_step.h"
#include "tests/support/limit_oracle.h"

namespace takt::test {

/// A cell without physics: an LWR that is always where it was sent, a force/torque sensor on its flange that feels the
/// weight of its tool and a stiff block, and a probing ball. The arm's base is turned and raised in the world, so a
/// frame that is mixed up shows. The block is not where the cell believes it is; `X_WO_true` says where it is.
class FakeCell {
 public:
  static constexpr double kStiffness = 1e6;  ///< N/m: 5 N are felt 5 um deep
  static constexpr double kToolMass = 0.4;   ///< kg

  /// @param more  adds devices before the first cycle
  explicit FakeCell(const std::function<void()>& more = {}) {
    auto model = device::read_arm("models/lwr4plus");
    if (!model) {
      ADD_FAILURE() << model.error().to_string();
      return;
    }
    arm = *model;
    backend = std::make_shared<FakeArm>(arm->home);
    core.add(std::make_unique<device::Arm>("arm", arm, backend, core.period()));
    sensor = std::make_shared<FakeForceTorqueSensor>();
    core.add(std::make_unique<device::ForceTorqueSensor>(
        "wrist", std::make_shared<const device::ForceTorqueDescription>(), sensor));
    speed = *core.declare({.name = "override", .unit = "1", .initial = net::Real{1.0}});
    cell.channels["override"] = speed;
    cell.override_channel = "override";
    describe();
    if (more) more();
    feel();
    core.step();
  }

  /// One cycle, in which the sensor feels where the arm was at its beginning.
  void step(int cycles = 1) {
    for (int i = 0; i < cycles; ++i) {
      feel();
      run_cycle();
    }
  }
  /// How step() runs one cycle of the core: it must not allocate.
  std::function<void()> run_cycle = [this] { guarded_step(core); };

  Eigen::Isometry3d tool_in_world(const device::JointVector& q) const {
    return X_WB * arm->chain->forward(q) * cell.arms.at("arm").X_FT;
  }
  /// The set point of now.
  const device::JointVector& q() const { return core_arm().set_point().q; }
  const device::Arm& core_arm() const { return *cell.arms.at("arm").device; }

  /// Largest use of a limit by all that was sent since the beginning, by an oracle of its own; > 1 = broken.
  double worst_limit_share() const {
    const auto list = [](const device::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
    const auto& l = arm->limits;
    LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3,
                       1e-11);
    for (const auto& sent : backend->sent) oracle.add(list(sent.q));
    if (oracle.range_excess > 0) return std::numeric_limits<double>::infinity();
    return std::max({oracle.velocity.share, oracle.acceleration.share, oracle.jerk.share});
  }

  std::shared_ptr<const device::ArmDescription> arm;
  std::shared_ptr<FakeArm> backend;
  std::shared_ptr<FakeForceTorqueSensor> sensor;
  rcc::ControlCore core{{}};
  device::Channel* speed = nullptr;  ///< override of all planned motions, 0 to 1
  expression::Cell cell;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();       ///< arm's base in the world
  Eigen::Isometry3d X_WO_true = Eigen::Isometry3d::Identity();  ///< where the block is
  net::Wrench bias{.force = {1.5, -2.5, 4.0}, .torque = {0.1, 0.2, -0.3}};
  net::Wrench extra;  ///< on top of all, in the sensor's axes: what a test wants it to feel

 private:
  void describe() {
    X_WB.translation() << 0.3, -0.2, 0.75;
    X_WB.linear() = Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    expression::MountedArm mounted;
    mounted.device = core.find_arm("arm");
    mounted.X_FT.translation().z() = 0.15;
    mounted.tip.ball_radius = 0.005;
    mounted.start = arm->home;
    cell.arms["arm"] = mounted;
    expression::MountedSensor wrist;
    wrist.device = dynamic_cast<device::ForceTorqueSensor*>(core.environment().find("wrist"));
    wrist.arm = "arm";
    wrist.X_FS.translation().z() = 0.03;
    wrist.X_FS.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    wrist.tool_mass = kToolMass;
    wrist.p_SC << 0.0, 0.01, 0.05;
    cell.sensors["wrist"] = wrist;
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    X_WO.translation() = X_WB * Eigen::Vector3d(0.56, 0.0, 0.1);
    EXPECT_TRUE(cell.frames.add("arm", "world", X_WB).empty());
    EXPECT_TRUE(cell.frames.add("block", "world", X_WO).empty());
    cell.objects["block"] = {"block", {{world::Box{{0.1, 0.06, 0.05}}}}};
    X_WO_true = X_WO;
  }

  /// Weight of the tool, the block's push on the ball, bias, and what the test adds.
  void feel() {
    const expression::MountedSensor& wrist = cell.sensors.at("wrist");
    const Eigen::Isometry3d X_WS = X_WB * arm->chain->forward(backend->state().q) * wrist.X_FS;
    const Eigen::Vector3d p_WT = tool_in_world(backend->state().q).translation();
    const Eigen::Vector3d weight = X_WS.linear().transpose() * cell.gravity_W * wrist.tool_mass;
    const Eigen::Vector3d push = X_WS.linear().transpose() * block_force(p_WT);
    const Eigen::Vector3d p_ST = X_WS.inverse() * p_WT;
    sensor->sample.wrench = {.force = bias.force + extra.force + weight + push,
                             .torque = bias.torque + extra.torque + wrist.p_SC.cross(weight) + p_ST.cross(push)};
  }

  Eigen::Vector3d block_force(const Eigen::Vector3d& p_WT) const {
    const world::Object& block = cell.objects.at("block");
    const Eigen::Vector3d p_O = X_WO_true.inverse() * p_WT;
    const double depth = cell.arms.at("arm").tip.ball_radius - world::signed_distance(block, p_O);
    if (depth <= 0.0) return Eigen::Vector3d::Zero();
    Eigen::Vector3d gradient;
    constexpr double kStep = 1e-7;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      gradient[i] = world::signed_distance(block, p_O + step) - world::signed_distance(block, p_O - step);
    }
    return X_WO_true.linear() * gradient.normalized() * kStiffness * depth;
  }
};

}  // namespace takt::test
