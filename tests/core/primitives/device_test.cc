// Driver primitives of grippers and signals: what they read and propose, null, and units.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/primitives/environment.h"
#include "tests/support/primitive_harness.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using device::GripperState;
using net::Boolean;
using net::Real;

class DevicePrimitives : public testing::Test {
 protected:
  PrimitiveHarness make(const std::string& type, nlohmann::ordered_json parameters) {
    return PrimitiveHarness(type, std::move(parameters), {.environment = &devices});
  }
  DeviceEnvironment devices;
};

TEST_F(DevicePrimitives, DigitalInputGivesLevelAndAgeOrNull) {
  auto input = make("DigitalInput", {{"device", "digital_input"}});
  devices.digital_input_backend->sample.value = true;
  devices.digital_input_backend->sample.stamp = kMillisecond;
  devices.digital_input->begin_cycle(3, 3 * kMillisecond);
  input.step();
  EXPECT_EQ(input.get<Boolean>("value"), true);
  EXPECT_EQ(input.get<Real>("age"), 0.002);
  devices.digital_input_backend->silent = true;
  devices.digital_input->begin_cycle(4, 4 * kMillisecond);
  input.step();
  EXPECT_TRUE(input.is_null("value"));
  EXPECT_TRUE(input.is_null("age"));
}

TEST_F(DevicePrimitives, AnalogInputIsNullWhereThereIsNothingToMeasure) {
  auto input = make("AnalogInput", {{"device", "analog_input"}});
  devices.analog_input_backend->sample.value = 2.5;
  devices.analog_input->begin_cycle(0, 0);
  EXPECT_EQ(input.step().get<Real>("value"), 2.5);
  devices.analog_input_backend->sample.value = std::numeric_limits<double>::infinity();
  devices.analog_input->begin_cycle(1, 0);
  EXPECT_TRUE(input.step().is_null("value"));
}

TEST_F(DevicePrimitives, OutputsProposeAndFailOnNull) {
  devices.digital_output->hold();
  devices.analog_output->hold();
  auto digital = make("DigitalOutput", {{"device", "digital_output"}});
  digital.set<Boolean>("value", true).step();
  devices.digital_output->hand_over();
  EXPECT_TRUE(devices.digital_output_backend->written.back());
  digital.set_null("value").step();
  EXPECT_EQ(digital.signals().cause.code, net::Cause::Code::kNullInput);

  auto analog = make("AnalogOutput", {{"device", "analog_output"}});
  auto state = make("AnalogOutputState", {{"device", "analog_output"}});
  EXPECT_EQ(state.step().get<Real>("sent"), 0.0) << "its initial value";
  analog.set<Real>("value", 3.5).step();
  devices.analog_output->hand_over();
  EXPECT_EQ(devices.analog_output_backend->written.back(), 3.5);
  EXPECT_EQ(state.step().get<Real>("sent"), 3.5);
  EXPECT_EQ(state.get<Boolean>("ready"), true);
}

TEST_F(DevicePrimitives, U1_UnitOfTheDeviceIsThatOfThePorts) {
  net::NetDescription net;
  net.add("in", "AnalogInput", {{"device", "analog_input"}});
  net.add("twice", "Gain", {{"factor", 2.0}});
  net.add("out", "AnalogOutput", {{"device", "analog_output"}});
  net.add("end", "Termination", {{"condition", false}});
  net.link("in.value", "twice.input");
  net.link("twice.value", "out.value");
  const auto right = net::CompiledNet::compile(net, devices);
  EXPECT_TRUE(right) << right.error().to_string();
  net.add("stopwatch", "Stopwatch", {{"running", true}});
  net.add("sum", "Add");
  net.link("in.value", "sum.a");
  net.link("stopwatch.elapsed", "sum.b");
  const auto mixed = net::CompiledNet::compile(net, devices);
  ASSERT_FALSE(mixed) << "a volt is not a second";
  EXPECT_THAT(mixed.error(), Reports(Code::kUnitMismatch, "/links/3", {"V"}));
}

TEST_F(DevicePrimitives, GripperCommandProposesAndFailsOnNull) {
  devices.gripper->hold();
  auto command = make("GripperCommand", {{"device", "gripper"}});
  command.set<Real>("width", 0.02).set<Real>("speed", 0.1).set<Real>("force", 30.0).step();
  devices.gripper->hand_over();
  ASSERT_EQ(devices.gripper_backend->written.size(), 1u);
  EXPECT_EQ(devices.gripper_backend->written[0].force, 30.0);
  command.set_null("force").step();
  EXPECT_EQ(command.signals().cause.code, net::Cause::Code::kNullInput);
}

TEST_F(DevicePrimitives, GripperStateSpeaksOfTheNewestCommandOnly) {
  devices.gripper->hold();
  auto state = make("GripperState", {{"device", "gripper"}});
  const auto cycle = [&](GripperState is, double width, bool answered) {
    devices.gripper_backend->answer(is, width);
    if (!answered) devices.gripper_backend->sample.command = 0;
    devices.gripper->begin_cycle(0, 0);
    state.step();
  };
  cycle(GripperState::kIdle, 0.11, true);
  EXPECT_EQ(state.get<Boolean>("open"), true);
  EXPECT_EQ(state.get<Boolean>("moving"), false);
  devices.gripper->propose(0.0, 0.1, 40);
  devices.gripper->hand_over();
  cycle(GripperState::kIdle, 0.11, false);
  EXPECT_EQ(state.get<Boolean>("moving"), true) << "the sample is of the time before the command";
  EXPECT_EQ(state.get<Boolean>("open"), false);
  cycle(GripperState::kHolding, 0.04, true);
  EXPECT_EQ(state.get<Boolean>("holding"), true);
  EXPECT_EQ(state.get<Real>("width"), 0.04);
  cycle(GripperState::kLost, 0.0, true);
  EXPECT_EQ(state.get<Boolean>("lost"), true);
  EXPECT_EQ(state.get<Boolean>("holding"), false);
  cycle(GripperState::kIdle, 0.0, true);
  EXPECT_EQ(state.get<Boolean>("closed"), true);
  devices.gripper_backend->silent = true;
  devices.gripper->begin_cycle(1, 0);
  state.step();
  for (const char* port : {"width", "moving", "holding", "lost", "open", "closed"}) EXPECT_TRUE(state.is_null(port));
  EXPECT_EQ(state.get<Boolean>("ready"), false);
}

TEST_F(DevicePrimitives, OneNetHoldsEachOutput) {
  net::NetDescription net;
  net.add("a", "DigitalOutput", {{"device", "digital_output"}, {"value", true}});
  net.add("b", "DigitalOutput", {{"device", "digital_output"}, {"value", false}});
  net.add("end", "Termination", {{"condition", true}});
  const auto compiled = net::CompiledNet::compile(net, devices);
  ASSERT_FALSE(compiled);
  EXPECT_THAT(compiled.error(), Reports(Code::kResourceConflict, "/primitives/1/parameters/device", {"driven"}));
}

}  // namespace
}  // namespace takt::test
