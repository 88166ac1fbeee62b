// The terminals of a controller as an I/O block, over the connection of its arm: values both ways, a cable that is
// pulled, a controller that restarts, other clients; and which blocks they can be.
#include "hw/rtde/terminals.h"

#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hw/rtde/kind/lock_step_robot.h"
#include "tests/hw/rtde/controller_bench.h"
#include "tests/support/fake_arm.h"
#include "tests/support/fake_signals.h"

namespace takt::hw::rtde::terminals_test {
namespace {

using device::IoChannel;
using Kind = IoChannel::Kind;
using testing::HasSubstr;

IoChannel in_unit(IoChannel channel, const std::string& unit) {
  channel.unit = unit;
  return channel;
}

/// 10 + 18 digital, 2 + 2 analog: standard, configurable and tool outputs, voltages and currents.
device::IoDescription whole_block() {
  device::IoDescription io;
  for (int i = 0; i < 10; ++i) io.channels.push_back(test::fake_channel(Kind::kDigitalInput, fmt::format("di{}", i)));
  for (int i = 0; i < 18; ++i) io.channels.push_back(test::fake_channel(Kind::kDigitalOutput, fmt::format("do{}", i)));
  io.channels.push_back(in_unit(test::fake_channel(Kind::kAnalogInput, "ai0", 0.0, 10.0), "V"));
  io.channels.push_back(in_unit(test::fake_channel(Kind::kAnalogInput, "ai1", 0.0, 20.0), "mA"));
  io.channels.push_back(in_unit(test::fake_channel(Kind::kAnalogOutput, "ao0", 0.0, 10.0), "V"));
  io.channels.push_back(in_unit(test::fake_channel(Kind::kAnalogOutput, "ao1", 4.0, 20.0), "mA"));
  return io;
}

/// What is wired to the terminals: inputs that read what the test says, outputs that remember.
struct Plant {
  explicit Plant(const device::IoDescription& io) {
    for (const IoChannel& channel : io.channels) {
      if (channel.kind == Kind::kDigitalInput)
        terminals.digital_inputs[channel.name] = inputs[channel.name] = std::make_shared<test::FakeInput<bool>>();
      if (channel.kind == Kind::kAnalogInput)
        terminals.analog_inputs[channel.name] = levels[channel.name] = std::make_shared<test::FakeInput<double>>();
      if (channel.kind == Kind::kDigitalOutput)
        terminals.digital_outputs[channel.name] = lamps[channel.name] = std::make_shared<test::FakeOutput<bool>>();
      if (channel.kind == Kind::kAnalogOutput)
        terminals.analog_outputs[channel.name] = valves[channel.name] = std::make_shared<test::FakeOutput<double>>();
    }
  }
  [[nodiscard]] bool lamp(const std::string& name) const { return lamps.at(name)->written.back(); }
  [[nodiscard]] double valve(const std::string& name) const { return valves.at(name)->written.back(); }

  std::map<std::string, std::shared_ptr<test::FakeInput<bool>>> inputs;
  std::map<std::string, std::shared_ptr<test::FakeInput<double>>> levels;
  std::map<std::string, std::shared_ptr<test::FakeOutput<bool>>> lamps;
  std::map<std::string, std::shared_ptr<test::FakeOutput<double>>> valves;
  device::IoTerminals terminals;
};

/// Driver, wire and controller around an arm and a plant. Each cycle the core looks at all terminals.
struct TerminalBench {
  explicit TerminalBench(const device::IoDescription& block = whole_block())
      : io(std::make_shared<const device::IoDescription>(block)), plant(*io) {
    EXPECT_TRUE(robot.begin());
    driver = robot.terminals(plant.terminals);
  }
  void cycles(int count) {
    device::ArmSample ignored;
    device::SignalSample<bool> bit;
    device::SignalSample<double> level;
    for (int i = 0; i < count; ++i) {
      (void)robot.read(ignored);
      for (const auto& [name, one] : driver->terminals().digital_inputs)
        if (one->read(bit)) seen[name] = bit;
      for (const auto& [name, one] : driver->terminals().analog_inputs)
        if (one->read(level)) levels[name] = level;
      for (const auto& [name, one] : driver->terminals().digital_outputs) (void)one->ready();
      for (const auto& [name, one] : driver->terminals().analog_outputs) (void)one->ready();
    }
  }
  bool becomes_ready(int most = 4000) {
    for (int i = 0; i < most && !driver->ready(); ++i) cycles(1);
    return driver->ready();
  }
  void set(const std::string& name, bool value) { driver->terminals().digital_outputs.at(name)->write(value); }
  void set(const std::string& name, double value) { driver->terminals().analog_outputs.at(name)->write(value); }
  [[nodiscard]] Terminals& there() { return robot.robot().controller().io(); }

  std::shared_ptr<const device::IoDescription> io;
  Plant plant;
  std::shared_ptr<test::FakeArm> arm = std::make_shared<test::FakeArm>(test::ur5()->home);
  LockStepRobot robot{DriverOptions{},
                      ControllerOptions{},
                      {.device = "arm", .description = test::ur5(), .seed = 3, .terminals = io},
                      arm,
                      hw::VirtualFaults{.wire = {.transport = 100'000, .jitter = 200'000}}};
  device::IoDriver* driver = nullptr;
  std::map<std::string, device::SignalSample<bool>> seen;
  std::map<std::string, device::SignalSample<double>> levels;
};

TEST(RtdeTerminals, ValuesGoBothWays) {
  TerminalBench bench;
  ASSERT_TRUE(bench.becomes_ready()) << bench.driver->fault_text();
  bench.plant.inputs.at("di3")->sample.value = bench.plant.inputs.at("di9")->sample.value = true;
  bench.plant.levels.at("ai0")->sample.value = 2.5;
  bench.plant.levels.at("ai1")->sample.value = 12.0;
  for (const char* name : {"do2", "do9", "do17"}) bench.set(name, true);
  bench.set("ao0", 7.5);
  bench.set("ao1", 8.0);
  bench.cycles(50);
  EXPECT_TRUE(bench.seen["di3"].value && bench.seen["di9"].value);
  EXPECT_FALSE(bench.seen["di0"].value || bench.seen["di8"].value);
  EXPECT_EQ(bench.levels["ai0"].value, 2.5);
  EXPECT_NEAR(bench.levels["ai1"].value, 12.0, 1e-12) << "mA";
  EXPECT_EQ(bench.there().digital_out, 1U << 2 | 1U << 9 | 1U << 17);
  EXPECT_EQ(bench.there().analog_types >> 2 & 0b11, 0b01) << "a voltage and a current";
  EXPECT_TRUE(bench.plant.lamp("do2") && bench.plant.lamp("do9") && bench.plant.lamp("do17"));
  EXPECT_FALSE(bench.plant.lamp("do0") || bench.plant.lamp("do16"));
  EXPECT_NEAR(bench.plant.valve("ao0"), 7.5, 1e-9);
  EXPECT_NEAR(bench.plant.valve("ao1"), 8.0, 1e-9);
  bench.set("do9", false);
  bench.cycles(50);
  EXPECT_EQ(bench.there().digital_out, 1U << 2 | 1U << 17);
}

TEST(RtdeTerminals, SamplesAreNumberedAndStampedOnTheCoresClock) {
  TerminalBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  bench.cycles(100);
  const device::SignalSample<bool> before = bench.seen["di0"];
  bench.cycles(80);
  const device::SignalSample<bool> after = bench.seen["di0"];
  EXPECT_EQ(after.sequence, before.sequence + 10) << "125 packages a second";
  EXPECT_NEAR(to_seconds(after.stamp - before.stamp), 0.08, 1e-3);
}

TEST(RtdeTerminals, WhatAModelSaysOfTheBeginningIsWrittenFirst) {
  device::IoDescription io = whole_block();
  for (IoChannel& channel : io.channels)
    if (channel.name == "do4") channel.initial = 1.0;
  TerminalBench bench(io);
  ASSERT_TRUE(bench.becomes_ready());
  bench.cycles(50);
  EXPECT_EQ(bench.there().digital_out, 1U << 4);
}

TEST(RtdeTerminals, AfterACableThatWasPulledOutputsAreWrittenAfterAResetOnly) {
  TerminalBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  bench.set("do1", true);
  bench.cycles(50);
  bench.robot.network().set_cut(true);
  bench.cycles(3000);
  EXPECT_FALSE(bench.driver->ready());
  EXPECT_THAT(bench.driver->fault_text(), HasSubstr("connection to the controller was lost"));
  bench.robot.robot().restart();
  bench.robot.network().set_cut(false);
  const std::uint64_t sequence = bench.seen["di0"].sequence;
  bench.cycles(8000);
  EXPECT_GT(bench.seen["di0"].sequence, sequence + 100) << "inputs are read all the same";
  EXPECT_FALSE(bench.driver->ready());
  EXPECT_EQ(bench.there().digital_out, 0U) << "nothing switches on by itself";
  bench.driver->reset();
  bench.cycles(50);
  EXPECT_TRUE(bench.driver->ready());
  EXPECT_EQ(bench.there().digital_out, 1U << 1);
}

TEST(RtdeTerminals, AnArmWithoutABlockKeepsNoClientFromItsOutputs) {
  device::IoDescription io;
  io.channels = {test::fake_channel(Kind::kDigitalInput, "di0")};
  TerminalBlock inputs_only(io, [](std::uint32_t) { return std::string(); });
  EXPECT_TRUE(inputs_only.fields().empty());
  EXPECT_FALSE(inputs_only.take_outputs());
  io.channels.push_back(test::fake_channel(Kind::kDigitalOutput, "do0"));
  TerminalBlock one_output(io, [](std::uint32_t) { return std::string(); });
  EXPECT_EQ(one_output.fields(), (std::vector<std::string>{"standard_digital_output_mask", "standard_digital_output"}));
  TerminalBlock all(whole_block(), [](std::uint32_t) { return std::string(); });
  EXPECT_EQ(all.fields().size(), 10u);
}

TEST(RtdeTerminals, BlocksThatAControllerCannotBeAreRefusedWithTheReason) {
  EXPECT_EQ(refuse_terminals(whole_block()), "");
  EXPECT_THAT(refuse_terminals({}), HasSubstr("no terminals"));
  const auto refusal = [](const IoChannel& channel, int count = 1) {
    device::IoDescription io;
    io.channels.assign(static_cast<std::size_t>(count), channel);
    return refuse_terminals(io);
  };
  EXPECT_THAT(refusal(test::fake_channel(Kind::kDigitalInput, "di"), 19), HasSubstr("19 digital inputs"));
  EXPECT_THAT(refusal(test::fake_channel(Kind::kDigitalOutput, "do"), 19), HasSubstr("19 digital outputs"));
  const IoChannel voltage = in_unit(test::fake_channel(Kind::kAnalogInput, "ai", 0.0, 10.0), "V");
  EXPECT_THAT(refusal(voltage, 3), HasSubstr("3 analog inputs"));
  EXPECT_THAT(refusal(in_unit(voltage, "bar")), HasSubstr("'bar'"));
  EXPECT_THAT(refusal(in_unit(test::fake_channel(Kind::kAnalogOutput, "ao", -10.0, 10.0), "V")),
              HasSubstr("0 to 10 V"));
  EXPECT_THAT(refusal(in_unit(test::fake_channel(Kind::kAnalogOutput, "ao", 0.0, 20.0), "mA")),
              HasSubstr("4 to 20 mA"));
  EXPECT_EQ(refusal(in_unit(test::fake_channel(Kind::kAnalogOutput, "ao", 0.004, 0.02), "A")), "");
}

}  // namespace
}  // namespace takt::hw::rtde::terminals_test
