// Sensors that read wrong, as the "faults" of a scenario ask for, and what the core makes of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/cell/described.h"
#include "tests/support/reports.h"

namespace takt::cell::sensor_faults_test {
namespace {

using takt::test::Reports;
using test::models;
using test::parsed;

std::string scenario(const std::string& steps, const std::string& faults) {
  return R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}}},
    "program": {"do": "sequence", "steps": [)" +
         steps + R"(]}, "faults": [)" + faults + "]}";
}

/// Readings of the sensor in each cycle; nothing: there was none.
std::vector<std::optional<Eigen::Vector3d>> readings(const std::string& fault) {
  auto session = Session::create(parsed(scenario(R"({"do": "wait", "seconds": 1})", fault)), models());
  EXPECT_TRUE(session) << session.error().to_string();
  std::vector<std::optional<Eigen::Vector3d>> forces;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    const device::ForceTorqueSensor& sensor = *built.cell.sensors.at("wrist").device;
    forces.push_back(sensor.has_sample() ? std::optional(sensor.sample().wrench.force) : std::nullopt);
    return true;
  };
  EXPECT_EQ((*session)->run(options).verdict, Verdict::kPassed);
  return forces;
}

std::string from_300_to_600(const std::string& fault) {
  return R"({"at_s": 0.3, "do": "sensor", "sensor": "wrist", "seconds": 0.3, )" + fault + "}";
}

TEST(SensorFaults, WithoutOneNothingIsChanged) {
  const auto session = [](const std::string& faults) {
    return std::move(*Session::create(parsed(scenario(R"({"do": "wait", "seconds": 0.5})", faults)), models()));
  };
  const RunReport without = session("")->run({});
  const RunReport later = session(R"({"at_s": 100, "do": "sensor", "sensor": "wrist", "fault": "nan"})")->run({});
  EXPECT_EQ(without.digest, later.digest) << "the wrapper changes no bit";
}

TEST(SensorFaults, SilentAndNotANumberAreNull) {
  for (const char* fault : {R"("fault": "silent")", R"("fault": "nan")"}) {
    const auto forces = readings(from_300_to_600(fault));
    EXPECT_TRUE(forces.at(295)) << fault;
    for (std::size_t k = 305; k < 595; ++k) ASSERT_FALSE(forces.at(k)) << fault << " in cycle " << k;
    EXPECT_TRUE(forces.at(605)) << fault << ": well again";
  }
}

TEST(SensorFaults, AStuckReadingStays) {
  const auto forces = readings(from_300_to_600(R"("fault": "stuck")"));
  for (std::size_t k = 306; k < 595; ++k) ASSERT_EQ(*forces.at(k), *forces.at(305));
  EXPECT_NE(*forces.at(290), *forces.at(289)) << "it is noise that moves otherwise";
}

TEST(SensorFaults, AnOffsetAndNoiseAreAdded) {
  const auto well = readings("");
  const auto offset = readings(from_300_to_600(R"("fault": "bias", "force_N": [10, 0, -5])"));
  for (std::size_t k = 305; k < 595; ++k)
    ASSERT_LT((*offset.at(k) - *well.at(k) - Eigen::Vector3d(10, 0, -5)).norm(), 1e-9);
  const auto noisy = readings(from_300_to_600(R"("fault": "noise", "force_N": [2, 0, 0])"));
  double sum = 0.0;
  for (std::size_t k = 305; k < 595; ++k) sum += std::pow((*noisy.at(k) - *well.at(k)).x(), 2);
  EXPECT_NEAR(std::sqrt(sum / 290.0), 2.0, 0.3);
  EXPECT_EQ(*readings(from_300_to_600(R"("fault": "noise", "force_N": [2, 0, 0])")).at(400), *noisy.at(400))
      << "repeats";
}

TEST(SensorFaults, DelayedReadingsAreThoseOfBefore) {
  const auto well = readings("");
  const auto late = readings(from_300_to_600(R"("fault": "delay", "delay_s": 0.004)"));
  for (std::size_t k = 310; k < 595; ++k) ASSERT_EQ(*late.at(k), *well.at(k - 4)) << k;
  EXPECT_EQ(*late.at(605), *well.at(605));
}

/// reliability.md, row 8: becomes null at the driver; what needs the force ends with a reason, and nothing moves on.
TEST(SensorFaults, AGuardedMotionEndsWhenItsSensorFallsSilent) {
  for (const char* fault : {"silent", "nan"}) {
    auto session = Session::create(
        parsed(scenario(R"({"do": "tare"}, {"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.1]},
            "velocity_m_s": 0.01, "until": {"sensor": "wrist", "above_N": 5}})",
                        std::string(R"({"at_s": 3, "do": "sensor", "sensor": "wrist", "fault": ")") + fault + "\"}")),
        models());
    ASSERT_TRUE(session) << session.error().to_string();
    const RunReport report = (*session)->run({});
    EXPECT_EQ(report.verdict, Verdict::kError) << fault;
    EXPECT_LT(report.sim_time, 3.5) << "at once";
    const bool told = std::ranges::any_of(
        report.log, [](const LogEntry& entry) { return entry.source == "fault" && entry.name == "sensor"; });
    EXPECT_TRUE(told) << "the log says what was done to the sensor";
  }
}

TEST(SensorFaults, MistakesAreFoundInTheFile) {
  const auto wrong = [](const std::string& fault) {
    const auto description = parse_description(scenario(R"({"do": "wait", "seconds": 1})", fault));
    if (!description) return description.error();
    const auto session = Session::create(*description, models());
    return session ? Diagnostics() : session.error();
  };
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "wirst", "fault": "nan"})"),
              Reports(Code::kUnknownName, "/faults/0/sensor", {"wirst", "wrist"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "wrist", "fault": "slow"})"),
              Reports(Code::kUnknownName, "/faults/0/fault", {"slow", "delay"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "wrist", "fault": "bias"})"),
              Reports(Code::kMissing, "/faults/0", {"force_N"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "wrist", "fault": "delay", "delay_s": 2})"),
              Reports(Code::kOutOfRange, "/faults/0/delay_s", {"2"}));
  EXPECT_THAT(wrong(R"({"at_s": 1, "do": "sensor", "sensor": "wrist", "fault": "nan", "arm": "arm"})"),
              Reports(Code::kUnknownKey, "/faults/0/arm", {"arm"}));
}

}  // namespace
}  // namespace takt::cell::sensor_faults_test
