#pragma once

#include <map>
#include <memory>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "app/interfaces/two_arms.h"
#include "core/device/device_file.h"
#include "tests/support/fake_arm.h"

namespace takt::test {

/// Two LWR 4+ that look at each other, each with a wrist sensor, always where they were sent; or others along the x
/// axis.
class TwoArmCell {
 public:
  explicit TwoArmCell(const std::map<std::string, double>& arms_x = {{"left", 0.0}, {"right", 1.2}}) {
    arm = device::read_arm("models/lwr4plus").value();
    for (const auto& [name, x] : arms_x) add(name, x);
    const Diagnostics diagnostics = activity::declare_channels(core, cell);
    EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.to_string();
    core.step();
  }

  app::TwoArms pair() {
    const app::Actuator left(program, "left"), right(program, "right");
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.translation() << 0.6, 0.0, (left.frame("world").inverse() * left.flange()).translation().z();
    return {left, right, X_WC};
  }

  std::shared_ptr<const device::ArmDescription> arm;
  std::map<std::string, std::shared_ptr<FakeArm>> backends;
  std::map<std::string, std::shared_ptr<FakeForceTorqueSensor>> wrists;
  rcc::ControlCore core{{}};
  expression::Cell cell;
  activity::Runtime program{core, cell, [this] { core.step(); }};

 private:
  void add(const std::string& name, double x) {
    backends[name] = std::make_shared<FakeArm>(arm->home);
    Eigen::Isometry3d X_WB(Eigen::AngleAxisd(x > 0.0 ? std::numbers::pi : 0.0, Eigen::Vector3d::UnitZ()));
    X_WB.translation() << x, 0.0, 0.4;
    EXPECT_FALSE(cell.frames.add(name, "world", X_WB).has_errors());
    cell.arms[name].device = &core.add(std::make_unique<device::Arm>(name, arm, backends[name], core.period()));
    cell.arms[name].start = arm->home;
    wrists[name] = std::make_shared<FakeForceTorqueSensor>();
    cell.sensors[name + " wrist"] = {
        .device = &core.add(std::make_unique<device::ForceTorqueSensor>(
            name + " wrist", std::make_shared<const device::ForceTorqueDescription>(), wrists[name])),
        .arm = name};
  }
};

}  // namespace takt::test
