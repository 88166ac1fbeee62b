// What everything that presses takes from its sensor.
#include "core/operations/table/contact_figures.h"

#include <gtest/gtest.h>

#include "core/device/force_torque_sensor.h"
#include "core/operations/table/overlay.h"

namespace takt::operations {
namespace {

/// Its samples are 8 ms old when they are known.
struct LateSensor final : device::ForceTorqueBackend {
  bool read(device::WrenchSample&) override { return false; }
  [[nodiscard]] device::BackendTiming timing() const override { return {.sample_age = 8 * kMillisecond}; }
};

TEST(ContactFigures, AForceOffsetKnowsHowLateItsSensorIs) {
  device::ForceTorqueSensor sensor("wrist", std::make_shared<device::ForceTorqueDescription>(),
                                   std::make_shared<LateSensor>());
  expression::Cell cell;
  cell.sensors["wrist"].device = &sensor;
  ForceOffsetParameters offset{.sensor = "wrist"};
  offset.force = 4.0;
  const command::ForceControlParameters control = offset.control_parameters(cell).force;
  EXPECT_DOUBLE_EQ(control.sensor_delay, 0.008);
  EXPECT_DOUBLE_EQ(control.contact_force, 1.2);
  EXPECT_DOUBLE_EQ(control.release_share * control.contact_force, 0.4);
  offset.force = 50.0;
  EXPECT_DOUBLE_EQ(offset.control_parameters(cell).force.contact_force, 2.0);
}

}  // namespace
}  // namespace takt::operations
