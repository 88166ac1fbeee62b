#pragma once

#include <numbers>

#include "core/command/actions/device_action.h"
#include "core/command/actions/motion_action.h"
#include "core/command/command.h"
#include "core/expression/device_sensors.h"
#include "tests/core/command/command_runs.h"
#include "tests/support/fake_cell.h"
#include "tests/support/fake_signals.h"

namespace takt::command {

using test::CommandStatus;
using test::LoadedCommand;

}  // namespace takt::command

namespace takt::test {

/// What hangs on the devices of a CommandCell.
struct Terminals {
  std::shared_ptr<FakeOutput<bool>> driver_terminal = std::make_shared<FakeOutput<bool>>();
  std::shared_ptr<FakeOutput<bool>> lamp_terminal = std::make_shared<FakeOutput<bool>>();
  std::shared_ptr<FakeOutput<double>> valve_terminal = std::make_shared<FakeOutput<double>>();
  std::shared_ptr<FakeInput<bool>> button = std::make_shared<FakeInput<bool>>();
  std::shared_ptr<FakeGripper> fingers = std::make_shared<FakeGripper>();
};

/// The fake cell with two digital outputs, a digital input, an analog output, a gripper and channels beside the arm.
class CommandCell : public Terminals, public FakeCell {
 public:
  /// @param more  adds to it before the first cycle
  explicit CommandCell(const std::function<void(CommandCell&)>& more = {})
      : FakeCell([this, &more] {
          add_devices();
          if (more) more(*this);
        }) {
    run_cycle = [this, one = run_cycle] {
      button->sample.stamp = core.time();  // it answers in every cycle
      one();
    };
  }

  command::Actuator arm_actuator() const { return command::arm(cell, "arm"); }
  command::Actuator driver() const { return command::output(cell, "driver"); }
  command::Actuator lamp() const { return command::output(cell, "lamp"); }

  device::JointVector joints(double a1, double a4 = 0.0) const {
    device::JointVector goal = arm->home;
    goal[0] += a1;
    goal[3] += a4;
    return goal;
  }
  /// The tool moved by this way, in the axes of the base.
  Eigen::Isometry3d moved(double x, double y, double z) const {
    Eigen::Isometry3d X_BT = arm->chain->forward(q()) * cell.arms.at("arm").X_FT;
    X_BT.translation() += Eigen::Vector3d(x, y, z);
    return X_BT;
  }
  expression::WrenchSensor felt() const { return expression::contact_wrench(cell, "wrist", {{"wrist", bias}}); }
  expression::State hard(double newton = 5.0) const {
    return expression::is_greater(expression::norm(expression::force(felt())), newton);
  }

  /// Runs cycles until the command has ended.
  CommandStatus run(LoadedCommand& command) { return command.wait(); }

  CommandRuns runtime{core, cell, [this] { step(); }};

 private:
  void add_devices() {
    cell.digital_outputs["driver"] = &core.add(std::make_unique<device::DigitalOutput>(
        "driver", device::SignalOutputDescription<bool>{}, driver_terminal, core.period()));
    cell.digital_outputs["lamp"] = &core.add(std::make_unique<device::DigitalOutput>(
        "lamp", device::SignalOutputDescription<bool>{}, lamp_terminal, core.period()));
    device::SignalOutputDescription<double> valve{.unit = "V", .lower = 0.0, .upper = 10.0, .rate_max = 100.0};
    cell.analog_outputs["valve"] =
        &core.add(std::make_unique<device::AnalogOutput>("valve", valve, valve_terminal, core.period()));
    cell.digital_inputs["button"] =
        &core.add(std::make_unique<device::DigitalInput>("button", device::SignalInputDescription<bool>{}, button));
    cell.grippers["gripper"] = {
        &core.add(std::make_unique<device::Gripper>(
            "gripper", std::make_shared<const device::GripperDescription>(fake_gripper_description()), fingers)),
        "arm"};
    using net::ValueType;
    declare({.name = "speed", .type = ValueType::kReal, .unit = "1", .initial = 1.0});
    declare({.name = "enable", .type = ValueType::kBoolean, .timeout = 50 * kMillisecond});
    declare({.name = "stick", .type = ValueType::kTwist, .unit = "m/s,rad/s", .timeout = 50 * kMillisecond});
    declare({
        .name = "target",
        .type = ValueType::kFrame,
    });
    declare({.name = "posture", .type = ValueType::kJoints, .unit = "rad"});
  }
  void declare(const device::ChannelDescription& description) {
    auto declared = core.declare(description);
    if (!declared) {
      ADD_FAILURE() << declared.error().to_string();
      return;
    }
    cell.channels[description.name] = *declared;
  }
};

}  // namespace takt::test
