// Inputs that read wrong and connections that fail, as the "faults" of a scenario ask for, and what comes of it
// (reliability.md, section 5: rows 1, 6, 8, 9, 10).
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/judge/limit_monitor.h"
#include "cell/run/session.h"
#include "core/device/signal.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::device_faults_test {
namespace {

using takt::test::Reports;
using test::models;
using test::parsed;
using test::refusal;

/// An arm with a gripper beside a wall 1 m away from a light barrier and a range finder; an input that switches twice.
std::string scenario(const std::string& steps, const std::string& faults) {
  return R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "gripper": {"model": "wsg50", "on": "arm"},
      "barrier": {"model": "light_barrier", "at": {"position_m": [0, -1, 0.5]}},
      "finder": {"model": "range_finder", "at": {"position_m": [0, -2, 0.5]}},
      "io": {"model": "io_block", "at": {"position_m": [-1, -2, 0]}, "settings": {"di1": {"name": "door", "script": [
        {"at_s": 0, "value": false}, {"at_s": 0.4, "value": true}, {"at_s": 0.5, "value": false}]}}}},
    "objects": {"wall": {"shape": "box", "size_m": [0.1, 1, 1], "at": {"position_m": [1, -2, 0.5]}}},
    "program": {"do": "sequence", "name": "main", "steps": [)" +
         steps + R"(]}, "faults": [)" + faults + "]}";
}

std::string from_300_to_600(const std::string& sensor, const std::string& fault) {
  return R"({"at_s": 0.3, "do": "sensor", "sensor": ")" + sensor + R"(", "seconds": 0.3, )" + fault + "}";
}

/// What an input gave in each cycle of a second; nothing: null.
template <class T>
std::vector<std::optional<T>> readings(const std::string& input, const std::string& fault) {
  auto session = Session::create(parsed(scenario(R"({"do": "wait", "seconds": 1})", fault)), models());
  EXPECT_TRUE(session) << session.error().to_string();
  std::vector<std::optional<T>> values;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    const device::SignalInput<T>* signal = nullptr;
    if constexpr (std::is_same_v<T, bool>) {
      signal = built.cell.digital_inputs.at(input);
    } else {
      signal = built.cell.analog_inputs.at(input);
    }
    values.push_back(signal->has_sample() ? std::optional(signal->sample().value) : std::nullopt);
    return true;
  };
  EXPECT_EQ((*session)->run(options).verdict, Verdict::kPassed);
  return values;
}

TEST(InputFaults, WithoutOneNothingIsChanged) {
  const auto digest = [](const std::string& faults) {
    return test::run(parsed(scenario(R"({"do": "ptp", "to": "home"}, {"do": "grip", "force_N": 20})", faults))).digest;
  };
  EXPECT_EQ(digest(""), digest(R"({"at_s": 100, "do": "sensor", "sensor": "finder", "fault": "nan"},
      {"at_s": 100, "do": "sensor", "sensor": "io/door", "fault": "stuck"},
      {"at_s": 100, "do": "device", "device": "arm", "fault": "gone"},
      {"at_s": 100, "do": "device", "device": "gripper", "fault": "jammed"})"))
      << "what can fail changes no bit until it does";
}

TEST(InputFaults, SilentAndNotANumberAreNull) {
  for (const char* fault : {R"("fault": "silent")", R"("fault": "nan")"}) {
    const auto distances = readings<double>("finder", from_300_to_600("finder", fault));
    EXPECT_TRUE(distances.at(290)) << fault;
    for (std::size_t k = 310; k < 595; ++k) ASSERT_FALSE(distances.at(k)) << fault << " in cycle " << k;
    EXPECT_TRUE(distances.at(610)) << fault << ": well again";
  }
  const auto light = readings<bool>("barrier", from_300_to_600("barrier", R"("fault": "silent")"));
  for (std::size_t k = 310; k < 595; ++k) ASSERT_FALSE(light.at(k)) << k;
}

TEST(InputFaults, AStuckInputMissesWhatHappens) {
  const auto well = readings<bool>("io/door", "");
  ASSERT_TRUE(well.at(450).value()) << "the door is open from 0.4 to 0.5 s";
  const auto stuck = readings<bool>("io/door", from_300_to_600("io/door", R"("fault": "stuck")"));
  for (std::size_t k = 310; k < 595; ++k) ASSERT_FALSE(stuck.at(k).value()) << k;
}

TEST(InputFaults, AnInputReadsTheValueThatTheFaultSays) {
  const auto door = readings<bool>("io/door", from_300_to_600("io/door", R"("fault": "value", "value": true)"));
  for (std::size_t k = 310; k < 595; ++k) ASSERT_TRUE(door.at(k).value()) << k;
  EXPECT_FALSE(door.at(650).value());
  const auto finder = readings<double>("finder", from_300_to_600("finder", R"("fault": "value", "value": 0.25)"));
  for (std::size_t k = 310; k < 595; ++k) ASSERT_EQ(*finder.at(k), 0.25) << k;
}

TEST(InputFaults, AnOffsetAndNoiseAreAdded) {
  const auto well = readings<double>("finder", "");
  const auto offset = readings<double>("finder", from_300_to_600("finder", R"("fault": "bias", "value": 0.1)"));
  for (std::size_t k = 310; k < 595; ++k) ASSERT_NEAR(*offset.at(k) - *well.at(k), 0.1, 1e-12);
  const auto noisy = readings<double>("finder", from_300_to_600("finder", R"("fault": "noise", "value": 0.02)"));
  double sum = 0.0;
  for (std::size_t k = 310; k < 595; ++k) sum += std::pow(*noisy.at(k) - *well.at(k), 2);
  EXPECT_NEAR(std::sqrt(sum / 285.0), 0.02, 0.004);
}

TEST(InputFaults, DelayedAndLostReadingsAreOlder) {
  const auto well = readings<bool>("io/door", "");
  const auto edge = [](const auto& values) { return std::ranges::find(values, std::optional(true)) - values.begin(); };
  const auto late = readings<bool>("io/door", from_300_to_600("io/door", R"("fault": "delay", "delay_s": 0.01)"));
  EXPECT_NEAR(static_cast<double>(edge(late) - edge(well)), 10.0, 1.0);
  const auto lost = readings<double>("finder", from_300_to_600("finder", R"("fault": "loss", "share": 0.9)"));
  std::size_t repeats = 0, nulls = 0;
  for (std::size_t k = 310; k < 595; ++k) {
    nulls += lost.at(k) ? 0 : 1;
    repeats += lost.at(k) && lost.at(k) == lost.at(k - 1) ? 1 : 0;
  }
  EXPECT_GT(repeats, 100u);
  EXPECT_LT(nulls, 200u) << "what is old is not null until it is too old";
}

constexpr const char* kMoves = R"({"do": "lin", "name": "first", "to": {"by_m": [0, 0.2, 0]}, "velocity_m_s": 0.1},
                                  {"do": "lin", "name": "second", "to": {"by_m": [0, -0.2, 0]}, "velocity_m_s": 0.1})";

TEST(ConnectionFaults, AnArmThatIsGoneEndsTheProgramAndNothingGoesOnByItself) {
  Description description =
      parsed(scenario(kMoves, R"({"at_s": 1, "do": "device", "device": "arm", "fault": "gone", "seconds": 0.5})"));
  const auto ran = test::run_kept(std::move(description));
  EXPECT_EQ(ran.report.verdict, Verdict::kError);
  EXPECT_LT(ran.report.sim_time, 1.2) << "at once";
  EXPECT_THAT(ran.report.diagnostics, Reports(Code::kStopped, "/program/steps/0", {"first", "arm"}));
}

TEST(ConnectionFaults, AProgramThatHandlesItMovesOnceTheArmIsBack) {
  const std::string steps = R"({"do": "try", "steps": [)" + std::string(kMoves) +
                            R"(], "on_error": {"steps": [{"do": "wait", "seconds": 1},
                                {"do": "ptp", "name": "back", "to": "home", "speed": 0.2}]}})";
  Description description =
      parsed(scenario(steps, R"({"at_s": 1, "do": "device", "device": "arm", "fault": "gone", "seconds": 0.5})"));
  RunOptions options;
  std::unique_ptr<LimitMonitor> monitor;
  options.after_cycle = [&](BuiltCell& built) {
    const device::Arm& arm = *built.cell.arms.at("arm").device;
    if (!monitor)
      monitor = std::make_unique<LimitMonitor>(arm.description().limits, arm.description().joint_names, 1e-3);
    monitor->watch(arm);
    return true;
  };
  const auto ran = test::run_kept(std::move(description), options);
  EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  EXPECT_TRUE(monitor->held()) << monitor->worst().what;
  const auto& arm = *ran.cell().arms.at("arm").device;
  EXPECT_LT((arm.sample().q - arm.description().home).cwiseAbs().maxCoeff(), 1e-3) << "at home in the end";
}

/// Row 1: the set points in between hold the arm where it was told to be last; the next one brings it on.
TEST(ConnectionFaults, LostSetPointsAreBridged) {
  for (const double share : {0.01, 0.05, 0.2}) {
    const auto ran = test::run_kept(
        parsed(scenario(kMoves, R"({"at_s": 0, "do": "device", "device": "arm", "fault": "loss", "share": )" +
                                    std::to_string(share) + "}")));
    EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << share << ": " << ran.report.diagnostics.to_string();
  }
}

TEST(ConnectionFaults, AGripperThatIsGoneFailsItsStep) {
  const auto ran =
      test::run_kept(parsed(scenario(R"({"do": "grip", "name": "grip", "force_N": 20})",
                                     R"({"at_s": 0.01, "do": "device", "device": "gripper", "fault": "gone"})")));
  EXPECT_EQ(ran.report.verdict, Verdict::kError);
  EXPECT_LT(ran.report.sim_time, 0.1) << "at once";
  EXPECT_THAT(ran.report.diagnostics, Reports(Code::kStopped, "/program/steps/0", {"grip", "gripper"}));
}

/// What it is told has no effect, so it never says that it has arrived: the step fails in time, and a program may go
/// on.
TEST(ConnectionFaults, JammedFingersFailTheirStepInTime) {
  const std::string jammed = R"({"at_s": 0, "do": "device", "device": "gripper", "fault": "jammed"})";
  const auto ran = test::run_kept(parsed(scenario(R"({"do": "grip", "name": "grip", "force_N": 20})", jammed)));
  const auto& gripper = *ran.cell().grippers.at("gripper").device;
  const device::GripperDescription& figures = gripper.description();
  EXPECT_THAT(ran.report.diagnostics,
              Reports(Code::kTimeout, "/program/steps/0", {"'gripper'", "close to 0.0 mm", "110.0 mm"}));
  EXPECT_NEAR(ran.report.sim_time, 2.0 * figures.stroke / (0.25 * figures.speed_max) + 1.0, 0.01);
  EXPECT_NEAR(gripper.sample().width, figures.stroke, 1e-4) << "as open as at the start";
  const std::string caught = R"({"do": "try", "steps": [{"do": "grip", "timeout_s": 0.3}],
                                 "on_error": {"steps": [{"do": "log", "text": "jammed"}]}})";
  const auto handled = test::run_kept(parsed(scenario(caught, jammed)));
  EXPECT_EQ(handled.report.verdict, Verdict::kPassed) << handled.report.diagnostics.to_string();
  EXPECT_NEAR(handled.report.sim_time, 0.3, 0.01);
}

TEST(ConnectionFaults, JammedFingersGoOnWhenTheyAreFree) {
  const auto ran = test::run_kept(
      parsed(scenario(R"({"do": "release", "name": "part way", "width_m": 0.05})",
                      R"({"at_s": 0, "do": "device", "device": "gripper", "fault": "jammed", "seconds": 0.5})")));
  EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  EXPECT_GT(ran.report.sim_time, 0.5);
  EXPECT_NEAR(ran.cell().grippers.at("gripper").device->sample().width, 0.05, 1e-3);
}

TEST(ConnectionFaults, TheyAreInTheLogAndRepeat) {
  const auto run = [] {
    return test::run(parsed(
        scenario(kMoves, R"({"at_s": 0.5, "do": "device", "device": "arm", "fault": "loss", "share": 0.1, "seconds": 1},
                            {"at_s": 0.7, "do": "sensor", "sensor": "finder", "fault": "noise", "value": 0.01})")));
  };
  const RunReport first = run();
  EXPECT_EQ(first.digest, run().digest);
  std::vector<std::string> told;
  for (const LogEntry& entry : first.log)
    if (entry.source == "fault") told.push_back(entry.name);
  EXPECT_EQ(told, (std::vector<std::string>{"device", "sensor", "device"})) << "with the end of the first";
}

TEST(DeviceFaults, MistakesAreFoundInTheFile) {
  const auto wrong = [](const std::string& fault) {
    const auto description = parse_description(scenario(R"({"do": "wait", "seconds": 1})", fault));
    return description ? refusal(*description) : description.error();
  };
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "io/dor", "fault": "stuck"})"),
              Reports(Code::kUnknownName, "/faults/0/sensor", {"io/dor", "io/door"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "io/door", "fault": "nan"})"),
              Reports(Code::kInvalidValue, "/faults/0/fault", {"nan", "stuck"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "finder", "fault": "noise"})"),
              Reports(Code::kMissing, "/faults/0", {"value"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "finder", "fault": "value"})"),
              Reports(Code::kMissing, "/faults/0", {"value"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "arm", "fault": "silent"})"),
              Reports(Code::kUnknownName, "/faults/0/sensor", {"arm"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "device", "device": "finder", "fault": "gone"})"),
              Reports(Code::kUnknownName, "/faults/0/device", {"finder"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "device", "device": "arm", "fault": "jammed"})"),
              Reports(Code::kInvalidValue, "/faults/0/fault", {"jammed", "gone"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "device", "device": "arm", "fault": "loss"})"),
              Reports(Code::kMissing, "/faults/0", {"share"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "device", "device": "arm", "fault": "loss", "share": 1.5})"),
              Reports(Code::kOutOfRange, "/faults/0/share", {"1.5"}));
}

}  // namespace
}  // namespace takt::cell::device_faults_test
