#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "hw/emulators/fri/controller.h"
#include "hw/fri/protocol/krl_words.h"
#include "tests/support/fake_arm.h"

namespace takt::hw::fri {

inline std::shared_ptr<const device::ArmDescription> lwr() {
  static const auto model = device::read_arm("models/lwr4plus");
  return model ? *model : nullptr;
}

/// A controller around an arm that is where it is told to be, and a remote side that a test writes.
class ControllerBench {
 public:
  explicit ControllerBench(const ControllerOptions& options = {},
                           std::shared_ptr<const device::ArmDescription> description = nullptr)
      : arm(description ? std::move(description)
                        : std::make_shared<const device::ArmDescription>(test::compliant_arm_description(kJoints))),
        controller(arm, options),
        period(options.cycle) {
    machine.q = device::JointVector::Constant(kJoints, 0.1);
    machine.dq = device::JointVector::Zero(kJoints);
    machine.ready = true;
  }

  /// One cycle; the remote side answers with `command`, its position mirrored unless `free`.
  void cycle() {
    controller.begin_cycle(now, machine);
    for (std::string& line : controller.news()) news += line + "\n";
    now += period;
    machine.q = controller.at(now).q;
    if (pushed) machine.q.setConstant(pushed(to_seconds(now)));
    machine.mode = mode.value_or(controller.mode());
    const Measurement* m = controller.measurement();
    if (m == nullptr) return;
    measured = *m;
    if (!answers) return;
    ++command.sequence;
    command.reflected = m->sequence;
    if (!free) command.q = m->q_before + m->q_offset;
    controller.take(command, now - period / 2);
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  void ask(State state, Control control = Control::kPosition) {
    command.krl.integer[takt_words::kWanted] = static_cast<std::int32_t>(state);
    command.krl.integer[takt_words::kStrategy] = strategy_of(control);
    ++command.krl.integer[takt_words::kRequest];
  }
  /// Command state, with the position held from then on.
  void start(Control control = Control::kPosition, std::uint32_t flags = kPositionFlags) {
    command.flags = flags;
    cycles(150);
    ask(State::kCommand, control);
    cycles(100);
    ASSERT_EQ(controller.state(), State::kCommand) << news;
    free = true;
    news.clear();
  }

  std::shared_ptr<const device::ArmDescription> arm;
  Controller controller;
  Nanoseconds period, now = 0;
  device::ArmSample machine;
  Measurement measured;
  Command command;
  bool answers = true, free = false;
  std::function<double(double)>
      pushed;  ///< s to rad: where somebody has all joints of the machine, wherever it is told
  std::optional<device::ControlMode> mode;  ///< in which the machine stays
  std::string news;
};

}  // namespace takt::hw::fri
