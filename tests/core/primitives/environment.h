#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/device/device_file.h"
#include "core/device/force_torque_sensor.h"
#include "core/net/primitive.h"
#include "tests/support/fake_arm.h"

namespace takt::test {

/// An LWR "arm" and a force/torque sensor "sensor", both ready, for primitives that speak to devices.
class DeviceEnvironment final : public net::Environment {
 public:
  DeviceEnvironment() {
    const auto description = device::read_arm("models/lwr4plus");
    if (!description) throw std::runtime_error(description.error().to_string());
    backend = std::make_shared<FakeArm>((*description)->home);
    arm = std::make_unique<device::Arm>("arm", *description, backend, kMillisecond);
    arm->begin_cycle(0, 0);
    sensor_backend = std::make_shared<FakeForceTorqueSensor>();
    sensor = std::make_unique<device::ForceTorqueSensor>(
        "sensor", std::make_shared<const device::ForceTorqueDescription>(), sensor_backend);
    sensor->begin_cycle(0, 0);
  }
  net::Resource* find(std::string_view name) override {
    if (name == "arm") return arm.get();
    return name == "sensor" ? sensor.get() : nullptr;
  }
  [[nodiscard]] std::vector<std::string> names() const override { return {"arm", "sensor"}; }

  std::shared_ptr<FakeArm> backend;
  std::unique_ptr<device::Arm> arm;
  std::shared_ptr<FakeForceTorqueSensor> sensor_backend;
  std::unique_ptr<device::ForceTorqueSensor> sensor;
};

}  // namespace takt::test
