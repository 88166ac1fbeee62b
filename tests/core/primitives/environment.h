#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/device/channel.h"
#include "core/device/composed_device.h"
#include "core/device/device_file.h"
#include "core/device/force_torque_sensor.h"
#include "core/net/primitive.h"
#include "core/primitives/cell_solids.h"
#include "tests/support/fake_arm.h"
#include "tests/support/fake_signals.h"

namespace takt::test {

/// An LWR, a force/torque sensor, a gripper and one signal of each kind, all ready, and for each type of values a
/// channel that nets write, for primitives that speak to devices; each is called as its kind.
class DeviceEnvironment final : public net::Environment {
 public:
  DeviceEnvironment() {
    static const auto description = device::read_arm("models/lwr4plus");  // read once: there are many environments
    if (!description) throw std::runtime_error(description.error().to_string());
    backend = std::make_shared<FakeArm>((*description)->home);
    arm = add(std::make_unique<device::Arm>("arm", *description, backend, kMillisecond));
    sensor_backend = std::make_shared<FakeForceTorqueSensor>();
    sensor = add(std::make_unique<device::ForceTorqueSensor>(
        "force_torque_sensor", std::make_shared<const device::ForceTorqueDescription>(), sensor_backend));
    gripper_backend = std::make_shared<FakeGripper>();
    gripper = add(std::make_unique<device::Gripper>(
        "gripper", std::make_shared<const device::GripperDescription>(fake_gripper_description()), gripper_backend));
    digital_input = add(std::make_unique<device::DigitalInput>("digital_input", device::SignalInputDescription<bool>{},
                                                               digital_input_backend));
    analog_input = add(std::make_unique<device::AnalogInput>(
        "analog_input", device::SignalInputDescription<double>{.unit = "V"}, analog_input_backend));
    digital_output = add(std::make_unique<device::DigitalOutput>(
        "digital_output", device::SignalOutputDescription<bool>{}, digital_output_backend, kMillisecond));
    analog_output = add(std::make_unique<device::AnalogOutput>(
        "analog_output", device::SignalOutputDescription<double>{.unit = "V"}, analog_output_backend, kMillisecond));
    solids = std::make_unique<primitives::CellSolids>(shapes_of_cell(**description));
    outputs = std::move(*device::ComposedDevice::make("composed_device", {digital_output, analog_output}));
    add_channels();
  }
  net::Resource* find(std::string_view name) override {
    for (const auto& channel : channels)
      if (channel->name() == name) return channel.get();
    if (name == outputs->name()) return outputs.get();
    if (name == primitives::CellSolids::kKind) return solids.get();
    const auto found = devices_.find(name);
    return found == devices_.end() ? nullptr : found->second.get();
  }
  [[nodiscard]] std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const auto& [name, device] : devices_) names.push_back(name);
    for (const auto& channel : channels) names.push_back(channel->name());
    names.emplace_back(primitives::CellSolids::kKind);
    return names;
  }

  std::shared_ptr<FakeArm> backend;
  device::Arm* arm;
  std::shared_ptr<FakeForceTorqueSensor> sensor_backend;
  device::ForceTorqueSensor* sensor;
  std::shared_ptr<FakeGripper> gripper_backend;
  device::Gripper* gripper;
  std::shared_ptr<FakeInput<bool>> digital_input_backend = std::make_shared<FakeInput<bool>>();
  std::shared_ptr<FakeInput<double>> analog_input_backend = std::make_shared<FakeInput<double>>();
  std::shared_ptr<FakeOutput<bool>> digital_output_backend = std::make_shared<FakeOutput<bool>>();
  std::shared_ptr<FakeOutput<double>> analog_output_backend = std::make_shared<FakeOutput<double>>();
  device::DigitalInput* digital_input;
  device::AnalogInput* analog_input;
  device::DigitalOutput* digital_output;
  device::AnalogOutput* analog_output;
  std::unique_ptr<device::ComposedDevice> outputs;  ///< both outputs as a whole
  std::vector<std::unique_ptr<device::Channel>> channels;
  std::unique_ptr<primitives::CellSolids> solids;  ///< the arm, and a block in front of it

  /// A block stands in front of the arm, on the level of its base.
  static std::shared_ptr<const collision::CellShapes> shapes_of_cell(const device::ArmDescription& model) {
    static const auto shapes = [&model] {
      auto made = std::make_shared<collision::CellShapes>();
      (void)made->scene.add_robot("arm", *model.robot, -1, Eigen::Isometry3d::Identity());
      Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
      X_WO.translation() << 0.75, 0.0, 0.25;
      made->scene.add_object("block", {{.shape = world::Box{{0.3, 0.8, 0.5}}}}, -1, X_WO);
      made->scene.find_pairs_that_never_meet();
      made->objects = {"block"};
      collision::CellShapes::Mechanism& mechanism = made->arms["arm"];
      for (const std::string& joint : model.joint_names)
        mechanism.joints.push_back(made->scene.find_joint("arm/" + joint));
      mechanism.flange = made->scene.find("arm/" + model.flange_link);
      return made;
    }();
    return shapes;
  }

 private:
  void add_channels() {
    using Writer = device::ChannelDescription::Writer;
    for (int t = 0; t <= static_cast<int>(net::ValueType::kJoints); ++t) {
      const auto type = static_cast<net::ValueType>(t);
      channels.push_back(*device::Channel::make(
          {.name = std::string(device::Channel::kind_of(type)), .type = type, .writer = Writer::kNet}));
    }
  }
  template <class Device>
  Device* add(std::unique_ptr<Device> device) {
    Device* added = device.get();
    added->begin_cycle(0, 0);
    devices_[added->name()] = std::move(device);
    return added;
  }

  std::map<std::string, std::unique_ptr<device::Device>, std::less<>> devices_;
};

}  // namespace takt::test
