// Terminals of a block behind a coupler on Modbus TCP: values, faults of the wire by seed, restarts, other servers; in
// virtual time and over sockets.
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "hw/modbus/twin.h"
#include "tests/support/fake_signals.h"

namespace takt::hw::modbus::driver_test {
namespace {

using Kind = device::IoChannel::Kind;

std::shared_ptr<const device::IoDescription> block() {
  auto io = std::make_shared<device::IoDescription>();
  io->channels = {test::fake_channel(Kind::kDigitalInput, "di1"),
                  test::fake_channel(Kind::kDigitalInput, "di2"),
                  test::fake_channel(Kind::kDigitalOutput, "do1"),
                  test::fake_channel(Kind::kDigitalOutput, "do2"),
                  test::fake_channel(Kind::kAnalogInput, "ai1", -10.0, 10.0),
                  test::fake_channel(Kind::kAnalogOutput, "ao1", 0.0, 10.0)};
  return io;
}

/// What is wired to the terminals.
struct Plant {
  Plant() {
    for (const char* name : {"di1", "di2"})
      terminals.digital_inputs[name] = inputs.emplace_back(new test::FakeInput<bool>);
    for (const char* name : {"do1", "do2"})
      terminals.digital_outputs[name] = outputs.emplace_back(new test::FakeOutput<bool>);
    terminals.analog_inputs["ai1"] = voltage;
    terminals.analog_outputs["ao1"] = valve;
  }
  [[nodiscard]] bool lamp(std::size_t i) const { return !outputs[i]->written.empty() && outputs[i]->written.back(); }
  [[nodiscard]] double opening() const { return valve->written.empty() ? -1.0 : valve->written.back(); }

  std::vector<std::shared_ptr<test::FakeInput<bool>>> inputs;
  std::vector<std::shared_ptr<test::FakeOutput<bool>>> outputs;
  std::shared_ptr<test::FakeInput<double>> voltage = std::make_shared<test::FakeInput<double>>();
  std::shared_ptr<test::FakeOutput<double>> valve = std::make_shared<test::FakeOutput<double>>();
  device::IoTerminals terminals;
};

TwinOptions ideal_wire() {
  TwinOptions options;
  options.faults.wire.transport = kMillisecond / 5;
  options.client.map.digital_outputs = options.coupler.map.digital_outputs = 512;
  options.client.map.analog_outputs = options.coupler.map.analog_outputs = 2048;
  return options;
}

/// The canonical signals on a driver, cycle by cycle as the core runs them.
struct Signals {
  Signals(const device::IoTerminals& on, Nanoseconds sample_age_max)
      : di1("di1", {.sample_age_max = sample_age_max}, on.digital_inputs.at("di1")),
        ai1("ai1", {.unit = "V", .sample_age_max = sample_age_max}, on.analog_inputs.at("ai1")),
        do1("do1", {.stop = false}, on.digital_outputs.at("do1"), kMillisecond),
        do2("do2", {}, on.digital_outputs.at("do2"), kMillisecond),
        ao1("ao1", {.unit = "V", .lower = 0.0, .upper = 10.0}, on.analog_outputs.at("ao1"), kMillisecond) {}

  void cycle(std::int64_t k) {
    const Nanoseconds now = k * kMillisecond;
    for (device::Device* device : std::initializer_list<device::Device*>{&di1, &ai1, &do1, &do2, &ao1})
      device->begin_cycle(k, now);
    if (do1.held() && do1.lost()) do1.stop();
    if (do2.held() && do2.lost()) do2.stop();
    if (lamp && do1.held()) do1.propose(*lamp);
    if (lamp && do2.held()) do2.propose(*lamp);
    if (opening && ao1.held()) ao1.propose(*opening);
    for (device::Actuator* one : std::initializer_list<device::Actuator*>{&do1, &do2, &ao1}) {
      (void)one->check();
      one->hand_over();
    }
  }
  void hold() {
    for (device::Actuator* one : std::initializer_list<device::Actuator*>{&do1, &do2, &ao1}) one->hold();
  }

  device::DigitalInput di1;
  device::AnalogInput ai1;
  device::DigitalOutput do1, do2;
  device::AnalogOutput ao1;
  std::optional<bool> lamp;
  std::optional<double> opening;
};

struct Bench {
  explicit Bench(const TwinOptions& options = ideal_wire(), std::uint64_t seed = 1)
      : twin({"io", block(), kMillisecond, seed}, options, plant.terminals) {
    EXPECT_TRUE(twin.begin());
    signals.emplace(twin.terminals(), 200 * kMillisecond);
  }
  bool until(const std::function<bool()>& done, int cycles = 5000) {
    for (int i = 0; i < cycles && !done(); ++i) {
      signals->cycle(k++);
      for (std::string& line : twin.news()) news += line + "\n";
    }
    return done();
  }
  void pass(int cycles) {
    (void)until([] { return false; }, cycles);
  }
  bool connect() {
    const bool there = until([this] { return twin.ready(); });
    signals->hold();
    return there;
  }

  Plant plant;
  Twin twin;
  std::optional<Signals> signals;
  std::int64_t k = 0;
  std::string news;
};

TEST(ModbusDriver, ValuesGoBothWays) {
  Bench bench;
  ASSERT_TRUE(bench.connect()) << bench.twin.fault_text();
  bench.plant.inputs[0]->sample.value = true;
  bench.plant.voltage->sample.value = -2.5;
  bench.signals->lamp = true;
  bench.signals->opening = 7.5;
  bench.pass(30);
  EXPECT_TRUE(bench.signals->di1.has_sample());
  EXPECT_TRUE(bench.signals->di1.sample().value);
  EXPECT_NEAR(bench.signals->ai1.sample().value, -2.5, 20.0 / 32'767);
  EXPECT_TRUE(bench.plant.lamp(0));
  EXPECT_TRUE(bench.plant.lamp(1));
  EXPECT_NEAR(bench.plant.opening(), 7.5, 10.0 / 32'767);
  EXPECT_EQ(bench.twin.coupler().coils(), (std::vector<std::uint16_t>{1, 1}));
  bench.plant.inputs[0]->sample.value = false;
  bench.signals->lamp = false;
  bench.pass(30);
  EXPECT_FALSE(bench.signals->di1.sample().value);
  EXPECT_FALSE(bench.plant.lamp(0));
  EXPECT_TRUE(bench.twin.fault_text().empty());
}

TEST(ModbusDriver, ASampleIsAsOldAsItsRequest) {
  Bench bench;
  ASSERT_TRUE(bench.connect());
  Nanoseconds oldest = 0;
  for (int i = 0; i < 500; ++i) {
    bench.pass(1);
    ASSERT_GE(bench.signals->di1.sample_age(), 0);
    oldest = std::max(oldest, bench.signals->di1.sample_age());
  }
  EXPECT_LE(oldest, 14 * kMillisecond) << "a cycle of 10 ms, four round trips, a cycle of the core";
}

TEST(ModbusDriver, AConnectionThatBrokeSwitchesNothingOnWithoutAReset) {
  Bench bench;
  ASSERT_TRUE(bench.connect());
  bench.signals->lamp = true;
  bench.pass(50);
  ASSERT_TRUE(bench.plant.lamp(1));
  bench.twin.network().set_cut(true);
  bench.pass(1500);
  EXPECT_FALSE(bench.twin.ready());
  EXPECT_NE(bench.twin.fault_text().find("connection"), std::string::npos) << bench.twin.fault_text();
  EXPECT_TRUE(bench.twin.coupler().watchdog_expired());
  EXPECT_FALSE(bench.plant.lamp(1)) << "the coupler switched it off";
  EXPECT_FALSE(bench.signals->di1.has_sample()) << "too old";
  bench.signals->lamp.reset();
  bench.twin.network().set_cut(false);
  bench.pass(3000);
  EXPECT_FALSE(bench.twin.ready());
  EXPECT_NE(bench.twin.fault_text().find("reset"), std::string::npos) << bench.twin.fault_text();
  EXPECT_TRUE(bench.signals->di1.has_sample()) << "inputs are read all the same";
  EXPECT_FALSE(bench.plant.lamp(1));
  bench.twin.reset();
  bench.pass(50);
  EXPECT_TRUE(bench.twin.ready());
  EXPECT_TRUE(bench.plant.lamp(1)) << "its stop reaction is to hold";
  EXPECT_FALSE(bench.plant.lamp(0)) << "its stop reaction is off";
}

TEST(ModbusDriver, WhatTheCouplerRefusesIsNamedWithItsSetting) {
  TwinOptions options = ideal_wire();
  options.client.map.analog_inputs = 100;
  Bench bench(options);
  EXPECT_FALSE(bench.connect());
  EXPECT_NE(bench.news.find("analog_inputs"), std::string::npos) << bench.news;
  EXPECT_NE(bench.news.find(name_of(Exception::kIllegalAddress)), std::string::npos) << bench.news;
  EXPECT_NE(bench.news.find("100"), std::string::npos) << bench.news;
  options = ideal_wire();
  options.client.map.unit = 9;
  Bench silent(options);
  EXPECT_FALSE(silent.connect());
  EXPECT_EQ(silent.twin.client().counts().exchanges, 0u);
}

TEST(ModbusDriver, FaultsOfTheWireBySeed) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    TwinOptions options = ideal_wire();
    options.faults.wire.jitter = 3 * kMillisecond;
    options.faults.stream_piece = 1 + seed % 9;
    Bench bench(options, seed);
    Random random(seed);
    ASSERT_TRUE(bench.connect()) << seed;
    for (int round = 0; round < 20; ++round) {
      bench.pass(static_cast<int>(random.bits() % 60));
      const auto fault = random.bits() % 3;
      const int lasts = static_cast<int>(random.bits() % 800);
      if (fault == 0) bench.twin.network().set_cut(true);
      if (fault == 1) bench.twin.frozen = true;
      if (fault == 2) bench.twin.coupler().restart();
      bench.pass(lasts);
      bench.twin.network().set_cut(false);
      bench.twin.frozen = false;
      bench.pass(1500);
      bench.twin.reset();
      bench.pass(30);
      ASSERT_TRUE(bench.twin.ready()) << "seed " << seed << " round " << round << bench.twin.fault_text() << bench.news;
      bench.signals->hold();
      const bool on = round % 2 == 0;
      bench.signals->lamp = on;
      bench.plant.inputs[0]->sample.value = on;
      bench.pass(80);
      ASSERT_EQ(bench.plant.lamp(0), on) << "seed " << seed << " round " << round;
      ASSERT_EQ(bench.signals->di1.sample().value, on) << "seed " << seed << " round " << round;
      bench.signals->lamp.reset();
    }
    EXPECT_EQ(bench.twin.client().counts().strange, 0u);
  }
}

TEST(ModbusDriver, TheSameSeedGivesTheSameRun) {
  const auto run = [](std::uint64_t seed) {
    TwinOptions options = ideal_wire();
    options.faults.wire.jitter = 3 * kMillisecond;
    Bench bench(options, seed);
    bench.signals->lamp = true;
    bench.pass(500);
    return std::vector<std::byte>(bench.twin.state().begin(), bench.twin.state().end());
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_NE(run(3), run(4));
}

TEST(ModbusCoupler, AnswersAsTheSpecificationHasIt) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  Plant plant;
  Coupler coupler({}, block(), network, plant.terminals);
  const auto ask = [&](const Request& request) { return coupler.answer(encode(request)); };
  EXPECT_EQ(ask({Function::kWriteCoil, 1, 1, {1}}), encode({Function::kWriteCoil, 1, 1, {1}}));
  EXPECT_EQ(ask({Function::kReadCoils, 0, 2}), std::string("\x01\x01\x02"));
  EXPECT_EQ(ask({Function::kWriteRegister, 0, 1, {0x1234}}), encode({Function::kWriteRegister, 0, 1, {0x1234}}));
  EXPECT_EQ(ask({Function::kReadHoldingRegisters, 0, 1}), std::string("\x03\x02\x12\x34"));
  plant.inputs[1]->sample.value = true;
  plant.voltage->sample.value = 10.0;
  coupler.look(0);
  EXPECT_EQ(ask({Function::kReadDiscreteInputs, 0, 2}), std::string("\x02\x01\x02"));
  EXPECT_EQ(ask({Function::kReadInputRegisters, 0, 1}), std::string("\x04\x02\x7F\xFF"));
  EXPECT_EQ(ask({Function::kReadInputRegisters, 0, 2}), encode_exception(4, Exception::kIllegalAddress));
  EXPECT_EQ(ask({Function::kReadCoils, 65'535, 2}), encode_exception(1, Exception::kIllegalAddress));
  EXPECT_EQ(coupler.answer("\x2B"), encode_exception(0x2B, Exception::kIllegalFunction));
  EXPECT_EQ(coupler.answer(""), encode_exception(0, Exception::kIllegalFunction));
  plant.voltage->sample.value = std::numeric_limits<double>::quiet_NaN();
  coupler.look(0);
  EXPECT_EQ(ask({Function::kReadInputRegisters, 0, 1}), std::string("\x04\x02\x7F\xFF"))
      << "nothing to measure: the last";
  coupler.restart();
  EXPECT_EQ(coupler.coils(), (std::vector<std::uint16_t>{0, 0}));
}

TEST(ModbusCoupler, AnswersItsUnitAndWhoeverNamesNone) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  Plant plant;
  Coupler coupler({.map = {.unit = 7}}, block(), network, plant.terminals);
  ASSERT_TRUE(coupler.listen({kLoopback, kPort}));
  ByteLink link(*network.connect({kLoopback, kPort}));
  FrameParser parser;
  std::vector<int> answered;
  std::uint16_t transaction = 0;
  for (const int unit : {7, 0, 255, 1, 254}) {
    std::string bytes;
    append_frame(bytes, {++transaction, static_cast<std::uint8_t>(unit), encode(Request{Function::kReadCoils, 0, 2})});
    link.send(bytes);
    for (int i = 0; i < 5; ++i) {
      clock.set(clock.now() + kMillisecond);
      coupler.advance(clock.now());
      link.receive([&](std::string_view received) { parser.feed(received); });
    }
    while (const auto frame = parser.next()) {
      EXPECT_EQ(frame->transaction, transaction);
      answered.push_back(frame->unit);
    }
  }
  EXPECT_EQ(answered, (std::vector<int>{7, 0, 255}));
}

TEST(ModbusCoupler, TakesTwentyClientsAndClosesWhoSpeaksOtherwise) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  Plant plant;
  Coupler coupler({}, block(), network, plant.terminals);
  ASSERT_TRUE(coupler.listen({kLoopback, kPort}));
  std::vector<std::unique_ptr<StreamLink>> links;
  for (int i = 0; i < 22; ++i) links.push_back(*network.connect({kLoopback, kPort}));
  for (int i = 0; i < 5; ++i) {
    clock.set(i * kMillisecond);
    coupler.advance(clock.now());
  }
  EXPECT_EQ(coupler.clients(), Coupler::kMostClients);
  const std::string http = "GET / HTTP/1.1\r\n\r\n";
  (void)links[0]->send(std::as_bytes(std::span(http)));
  for (int i = 5; i < 10; ++i) {
    clock.set(i * kMillisecond);
    coupler.advance(clock.now());
  }
  EXPECT_EQ(coupler.clients(), Coupler::kMostClients - 1);
}

TEST(ModbusDriver, OverSockets) {
  Plant plant;
  PosixNetwork network;
  CouplerOptions coupler_options;
  coupler_options.watchdog = 0;
  Coupler coupler(coupler_options, block(), network, plant.terminals);
  ClientOptions options;
  {
    const auto free_port = network.listen({kLoopback, 0});
    ASSERT_TRUE(free_port);
    options.remote = (*free_port)->local();
  }
  ASSERT_TRUE(coupler.listen(options.remote));
  MonotonicClock clock;
  Driver driver(options, {"io", block(), kMillisecond, 1}, clock);
  Signals signals(driver.terminals(), kSecond);
  signals.lamp = true;
  plant.inputs[0]->sample.value = true;
  plant.voltage->sample.value = 5.0;
  for (std::int64_t k = 0; k < 5000 && !(plant.lamp(0) && signals.di1.has_sample()); ++k) {
    coupler.advance(k * kMillisecond);
    if (driver.ready()) signals.hold();
    signals.cycle(clock.now() / kMillisecond);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(plant.lamp(0));
  EXPECT_TRUE(signals.di1.sample().value);
  EXPECT_NEAR(signals.ai1.sample().value, 5.0, 1e-3);
}

}  // namespace
}  // namespace takt::hw::modbus::driver_test
