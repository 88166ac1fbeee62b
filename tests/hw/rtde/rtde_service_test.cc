// Port 30004 of the emulated controller: what it answers, whom it refuses, when it sends.
#include "hw/emulators/rtde/rtde_service.h"

#include <limits>

#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

/// A client that says what a test wants and looks at what comes back.
struct RawClient {
  RawClient(RtdeService& service, test::ControllerBench& bench) : session(service.open()) {
    bench.sessions.push_back(session.get());
  }
  std::string ask(PackageType type, std::string_view payload = {}) {
    session->receive(make_package(type, payload));
    return take();
  }
  std::string take() { return std::exchange(session->out(), {}); }
  std::string version(int wanted) {
    std::string payload;
    append(payload, static_cast<std::uint16_t>(wanted));
    return ask(PackageType::kProtocolVersion, payload);
  }
  std::string outputs(std::string_view names, double frequency = 125.0, int protocol = 2) {
    session->receive(encode_output_request(frequency, names, protocol));
    return take();
  }
  std::string inputs(std::string_view names) { return ask(PackageType::kSetupInputs, names); }
  void data(int recipe, std::initializer_list<std::int32_t> values) {
    std::string payload(1, static_cast<char>(recipe));
    for (const std::int32_t value : values) append(payload, value);
    session->receive(make_package(PackageType::kData, payload));
  }
  std::unique_ptr<Session> session;
};

std::string reply(PackageType type, int id, const std::string& words) {
  return encode_setup_reply(type, static_cast<std::uint8_t>(id), words, true);
}
std::string flag(PackageType type, bool accepted) { return make_package(type, std::string(1, accepted ? '\1' : '\0')); }

class RtdeServer : public testing::Test {
 protected:
  test::ControllerBench bench;
  RtdeService service{bench.controller};
  RawClient client{service, bench};
};

TEST_F(RtdeServer, NegotiatesTheProtocol) {
  EXPECT_EQ(client.version(2), flag(PackageType::kProtocolVersion, true));
  EXPECT_EQ(client.version(1), flag(PackageType::kProtocolVersion, true));
  for (const int wanted : {0, 3, 99}) EXPECT_EQ(client.version(wanted), flag(PackageType::kProtocolVersion, false));
  EXPECT_EQ(client.ask(PackageType::kProtocolVersion, "x"), flag(PackageType::kProtocolVersion, false));
  EXPECT_EQ(client.ask(PackageType::kControllerVersion), encode_version(bench.controller.options().version));
}

TEST_F(RtdeServer, OutputsAreAnsweredWithTheirTypes) {
  (void)client.version(2);
  EXPECT_EQ(client.outputs("timestamp,actual_q,robot_mode,runtime_state,actual_digital_input_bits,joint_mode,"),
            reply(PackageType::kSetupOutputs, 1, "DOUBLE,VECTOR6D,INT32,UINT32,UINT64,VECTOR6INT32"));
  EXPECT_EQ(client.outputs("timestamp,nonsense"), reply(PackageType::kSetupOutputs, 0, "DOUBLE,NOT_FOUND"));
  EXPECT_EQ(client.ask(PackageType::kStart), flag(PackageType::kStart, false)) << "there is no valid recipe any more";
  EXPECT_EQ(client.outputs("ft_raw_wrench"), reply(PackageType::kSetupOutputs, 0, "NOT_FOUND")) << "e-Series only";
}

TEST_F(RtdeServer, FrequenciesThatCannotBeAreRefused) {
  (void)client.version(2);
  for (const double frequency : {0.0, -1.0, 126.0, 1e300, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(client.outputs("timestamp", frequency), reply(PackageType::kSetupOutputs, 0, "DOUBLE")) << frequency;
}

TEST_F(RtdeServer, SendsAtTheFrequencyThatWasAskedFor) {
  (void)client.version(2);
  (void)client.outputs("timestamp", 25.0);
  EXPECT_EQ(client.ask(PackageType::kStart), flag(PackageType::kStart, true));
  std::vector<double> times;
  for (int i = 0; i < 125; ++i) {
    bench.frame();
    const std::string package = client.take();
    if (package.empty()) continue;
    ASSERT_EQ(package.size(), 12u);
    ASSERT_EQ(package.substr(0, 4), std::string("\0\x0cU\1", 4));
    ByteReader reader(std::string_view(package).substr(4));
    times.push_back(reader.take<double>());
  }
  ASSERT_EQ(times.size(), 25u);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_NEAR(times[i] - times[i - 1], 0.04, 1e-12);
  EXPECT_EQ(client.ask(PackageType::kPause), flag(PackageType::kPause, true));
  bench.frames(10);
  EXPECT_EQ(client.take(), "");
  EXPECT_EQ(client.ask(PackageType::kPause), flag(PackageType::kPause, true));
}

TEST_F(RtdeServer, ProtocolOneHasNoIdsAndTheFullRate) {
  EXPECT_EQ(client.outputs("robot_mode", 0.0, 1), encode_setup_reply(PackageType::kSetupOutputs, 1, "INT32", false));
  (void)client.ask(PackageType::kStart);
  bench.frame();
  EXPECT_EQ(client.take(), make_package(PackageType::kData, std::string("\0\0\0\7", 4)));
}

TEST_F(RtdeServer, AClientThatDoesNotReadLosesPackagesAndNothingQueues) {
  (void)client.version(2);
  (void)client.outputs("actual_q,target_q,actual_qd,timestamp");
  (void)client.ask(PackageType::kStart);
  bench.frames(2000);
  EXPECT_LT(client.session->out().size(), Session::kBacklog + 1000);
  EXPECT_GT(service.counts().left_out, 1000u);
  (void)client.take();
  bench.frame();
  const std::string package = client.take();
  ByteReader reader(std::string_view(package).substr(package.size() - 8));
  EXPECT_NEAR(reader.take<double>(), to_seconds(bench.controller.time()), 1e-9) << "the newest comes next";
}

TEST_F(RtdeServer, InputRecipesCountFromOne) {
  (void)client.version(2);
  EXPECT_EQ(client.inputs("input_int_register_24,input_double_register_24,"),
            reply(PackageType::kSetupInputs, 1, "INT32,DOUBLE"));
  EXPECT_EQ(client.inputs("input_int_register_24"), reply(PackageType::kSetupInputs, 2, "INT32"))
      << "one client may repeat";
  EXPECT_EQ(client.inputs("no_register"), reply(PackageType::kSetupInputs, 0, "NOT_FOUND"));
  EXPECT_EQ(client.inputs("input_bit_register_64"), reply(PackageType::kSetupInputs, 3, "BOOL"));
}

TEST_F(RtdeServer, ARegisterBelongsToOneClient) {
  RawClient other(service, bench);
  EXPECT_EQ(client.inputs("input_int_register_24"), reply(PackageType::kSetupInputs, 1, "INT32"));
  EXPECT_EQ(other.inputs("input_int_register_25,input_int_register_24"),
            reply(PackageType::kSetupInputs, 0, "INT32,IN_USE"));
  EXPECT_EQ(client.inputs("input_int_register_25"), reply(PackageType::kSetupInputs, 2, "INT32"))
      << "what was refused claims nothing";
  bench.sessions.clear();
  client.session.reset();
  EXPECT_EQ(other.inputs("input_int_register_24"), reply(PackageType::kSetupInputs, 1, "INT32"))
      << "the first has left";
}

TEST_F(RtdeServer, InputsCountWithoutAStart) {
  (void)client.inputs("input_int_register_3,input_int_register_4");
  client.data(1, {7, -8});
  EXPECT_EQ(bench.controller.inputs().ints[3], 7);
  EXPECT_EQ(bench.controller.inputs().ints[4], -8);
  client.data(1, {1});
  EXPECT_EQ(bench.controller.inputs().ints[3], 1) << "the fields that are whole count";
  EXPECT_EQ(bench.controller.inputs().ints[4], -8);
  client.data(1, {2, 3, 4});
  EXPECT_EQ(bench.controller.inputs().ints[4], 3) << "the rest is ignored";
  EXPECT_EQ(service.counts().misshapen, 2u);
  bench.frame();
  EXPECT_EQ(bench.field("input_int_register_4"), 3.0);
}

TEST_F(RtdeServer, AnUnknownRecipeIsComplainedOfAfterTheStartOnly) {
  (void)client.version(2);
  client.data(9, {1});
  EXPECT_EQ(client.take(), "") << "a client in its set-up would take it for an answer";
  (void)client.outputs("timestamp");
  (void)client.ask(PackageType::kStart);
  client.data(9, {1});
  EXPECT_EQ(client.take()[2], 'M');
}

TEST_F(RtdeServer, MasksCountOnce) {
  (void)client.inputs("speed_slider_mask,speed_slider_fraction");
  std::string payload(1, '\1');
  append(payload, std::uint32_t{1});
  append(payload, 0.25);
  client.session->receive(make_package(PackageType::kData, payload));
  EXPECT_EQ(bench.controller.settings().slider, 0.25);
  (void)client.inputs(
      "standard_digital_output_mask,standard_digital_output,tool_digital_output_mask,tool_digital_output");
  client.session->receive(make_package(PackageType::kData, std::string("\2\x05\x04\x02\x02", 5)));
  EXPECT_EQ(bench.controller.io().digital_out, (2u << 16) | 4u);
  bench.controller.io().set_digital_out(2, false);
  client.session->receive(make_package(PackageType::kData, payload));
  EXPECT_FALSE(bench.controller.io().digital_output(2)) << "the mask has done its work";
}

TEST_F(RtdeServer, WhatIsNoNumberOrOutOfRangeCountsAsNotWritten) {
  (void)client.inputs(
      "input_double_register_3,speed_slider_mask,speed_slider_fraction,standard_analog_output_mask,"
      "standard_analog_output_type,standard_analog_output_0");
  const auto write = [&](double real, double slider, double analog) {
    std::string payload(1, '\1');
    append(payload, real);
    append(payload, std::uint32_t{1});
    append(payload, slider);
    payload += '\1';
    payload += '\1';
    append(payload, analog);
    client.session->receive(make_package(PackageType::kData, payload));
  };
  const auto expect_unchanged = [&] {
    EXPECT_EQ(bench.controller.inputs().reals[3], 2.5);
    EXPECT_EQ(bench.controller.settings().slider, 0.5);
    EXPECT_EQ(bench.controller.io().analog_out[0], 0.25);
  };
  write(2.5, 0.5, 0.25);
  expect_unchanged();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  for (const double wrong : {kNan, kInf, -kInf}) {
    write(wrong, wrong, wrong);
    expect_unchanged();
  }
  for (const double wrong : {-0.01, 1.01, 1e300}) {
    write(2.5, wrong, wrong);
    expect_unchanged();
  }
}

TEST_F(RtdeServer, WhatIsNoStreamOfPackagesIsClosed) {
  client.session->receive(std::string("\0\1S", 3));
  EXPECT_TRUE(client.session->closing());
  EXPECT_EQ(service.counts().broken, 1u);
}

TEST_F(RtdeServer, LongListsOfNamesDoNoHarm) {
  (void)client.version(2);
  std::string names;
  while (names.size() < 60'000) names += "target_q,";
  const std::string answer = client.outputs(names);
  EXPECT_EQ(answer[3], '\0') << "no package can hold so many values";
  EXPECT_LE(answer.size(), kLargestPackage);
}

TEST(RtdeServerE, AnESeriesSendsFiveHundredTimesASecond) {
  test::ControllerBench bench(test::e_series());
  RtdeService service(bench.controller);
  RawClient client(service, bench);
  (void)client.version(2);
  EXPECT_EQ(client.outputs("ft_raw_wrench,tool_output_mode", 500.0),
            reply(PackageType::kSetupOutputs, 1, "VECTOR6D,UINT8"));
  (void)client.ask(PackageType::kStart);
  bench.seconds(0.1);
  EXPECT_EQ(client.take().size(), 50u * (4 + 49));
  EXPECT_NEAR(to_seconds(bench.controller.cycle()), 0.002, 1e-12);
}

}  // namespace
}  // namespace takt::hw::rtde
