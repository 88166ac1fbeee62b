// When the driver lets the arm be moved.
#include "hw/fri/supervisor.h"

#include <gtest/gtest.h>

namespace takt::test {
namespace {

using hw::fri::Control;
using hw::fri::Fault;
using hw::fri::kAllDrives;
using hw::fri::Measurement;
using hw::fri::State;
using hw::fri::Supervisor;

Measurement in_command_state(std::uint16_t power) {
  Measurement m;
  m.state = State::kCommand;
  m.control = Control::kPosition;
  m.measurement_period = m.command_period = 1e-3;
  m.power = power;
  return m;
}

TEST(FriSupervisor, TheArmMayMoveOnlyWhileAllSevenDrivesHavePower) {
  const Supervisor supervisor(kMillisecond);
  for (std::uint16_t power = 0; power < kAllDrives; ++power) {
    EXPECT_EQ(supervisor.fault(in_command_state(power)), Fault::kDrivesOff) << power;
  }
  EXPECT_EQ(supervisor.fault(in_command_state(kAllDrives)), Fault::kNone);
}

TEST(FriSupervisor, BitsBeyondTheSevenDrivesDoNotCount) {
  const Supervisor supervisor(kMillisecond);
  EXPECT_EQ(supervisor.fault(in_command_state(0xff80 | kAllDrives)), Fault::kNone);
  EXPECT_EQ(supervisor.fault(in_command_state(0xff80)), Fault::kDrivesOff);
}

}  // namespace
}  // namespace takt::test
