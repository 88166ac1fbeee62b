#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/device/channel.h"
#include "core/device/device_file.h"
#include "core/device/force_torque_sensor.h"
#include "core/net/primitive.h"
#include "tests/support/fake_arm.h"

namespace takt::test {

/// An LWR and a force/torque sensor, both ready, and for each type of values a channel that nets write, for primitives
/// that speak to devices; each is called as its kind.
class DeviceEnvironment final : public net::Environment {
 public:
  DeviceEnvironment() {
    static const auto description = device::read_arm("models/lwr4plus");  // read once: there are many environments
    if (!description) throw std::runtime_error(description.error().to_string());
    backend = std::make_shared<FakeArm>((*description)->home);
    arm = std::make_unique<device::Arm>("arm", *description, backend, kMillisecond);
    arm->begin_cycle(0, 0);
    sensor_backend = std::make_shared<FakeForceTorqueSensor>();
    sensor = std::make_unique<device::ForceTorqueSensor>(
        "sensor", std::make_shared<const device::ForceTorqueDescription>(), sensor_backend);
    sensor->begin_cycle(0, 0);
    using Writer = device::ChannelDescription::Writer;
    for (int t = 0; t <= static_cast<int>(net::ValueType::kJoints); ++t) {
      const auto type = static_cast<net::ValueType>(t);
      channels.push_back(*device::Channel::make(
          {.name = std::string(device::Channel::kind_of(type)), .type = type, .writer = Writer::kNet}));
    }
  }
  net::Resource* find(std::string_view name) override {
    if (name == arm->kind()) return arm.get();
    for (const auto& channel : channels)
      if (channel->name() == name) return channel.get();
    return name == sensor->kind() ? sensor.get() : nullptr;
  }
  [[nodiscard]] std::vector<std::string> names() const override {
    std::vector<std::string> all{std::string(arm->kind()), std::string(sensor->kind())};
    for (const auto& channel : channels) all.push_back(channel->name());
    return all;
  }

  std::shared_ptr<FakeArm> backend;
  std::unique_ptr<device::Arm> arm;
  std::shared_ptr<FakeForceTorqueSensor> sensor_backend;
  std::unique_ptr<device::ForceTorqueSensor> sensor;
  std::vector<std::unique_ptr<device::Channel>> channels;
};

}  // namespace takt::test
