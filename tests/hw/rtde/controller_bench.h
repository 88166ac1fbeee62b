#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "hw/emulators/rtde/controller.h"
#include "hw/emulators/rtde/session.h"
#include "hw/rtde/message.h"

namespace takt::test {

/// The UR5 of models/.
inline std::shared_ptr<const device::ArmDescription> ur5() {
  static const auto arm = device::read_arm("models/ur5").value();
  return arm;
}

/// An emulated controller with an ideal arm: frames run as the test says.
class ControllerBench {
 public:
  /// @param network  for what the controller connects to; outlives the bench
  explicit ControllerBench(const hw::rtde::ControllerOptions& options = {}, hw::Network* network = nullptr)
      : controller(options, ur5(), network) {
    plant.q = ur5()->home;
    plant.dq = hw::rtde::JointVector::Zero(6);
    plant.tau_external = hw::rtde::JointVector::Zero(6);
  }
  void frame() {
    controller.run_frame(plant);
    plant.q = controller.told_next().q;
    plant.dq = controller.told_next().dq;
    for (hw::rtde::Session* session : sessions) session->end_frame();
  }
  void frames(int count) {
    for (int i = 0; i < count; ++i) frame();
  }
  void seconds(double time) { frames(static_cast<int>(time / to_seconds(controller.cycle()) + 0.5)); }
  /// Starts a program and runs it for at most so long. @return true if it has ended
  bool run(const std::string& script, double time = 10.0) {
    if (!controller.programs().start(script)) return false;
    const int most = static_cast<int>(time / to_seconds(controller.cycle()));
    for (int i = 0; i < most && controller.programs().running(); ++i) frame();
    return !controller.programs().running();
  }
  [[nodiscard]] double field(std::string_view name, std::size_t i = 0) const {
    return controller.fields()[hw::rtde::output_fields().at(name)][i];
  }
  /// The text of the last event of a kind; empty: there is none.
  [[nodiscard]] std::string last(hw::rtde::ControllerEvent::Kind kind) {
    std::string text;
    for (auto i = controller.events().begin(); i < controller.events().end(); ++i)
      if (controller.events()[i].kind == kind) text = controller.events()[i].text;
    return text;
  }

  hw::rtde::Controller controller;
  hw::rtde::PlantSample plant;
  std::vector<hw::rtde::Session*> sessions;
};

inline hw::rtde::ControllerOptions e_series() {
  hw::rtde::ControllerOptions options;
  options.version = {5, 12, 2, 1101534};
  options.model = "UR5e";
  return options;
}

}  // namespace takt::test
