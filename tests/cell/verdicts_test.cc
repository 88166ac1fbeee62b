// Verdicts that were wrong: contacts that nobody saw, forces that cancelled, stops that nobody noticed.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/base/output_file.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::verdicts_test {
namespace {

using takt::test::Names;
using takt::test::Reports;
using test::parsed;
using test::refusal;
using test::run;

// -- Contacts --------------------------------------------------------------------------------------------------------

/// A ball over a plate, with a gap under it, and nobody near.
Description ball(double gap, const std::string& expectations, const std::string& faults = "") {
  return parsed(R"({"devices": {"arm": {"model": "ur5", "at": {"position_m": [-1.5, 0, 0]}}},
    "objects": {
      "plate": {"shape": "box", "size_m": [0.2, 0.2, 0.02], "at": {"position_m": [0.4, 0, 0.01]}},
      "ball": {"shape": "sphere", "radius_m": 0.02, "fixed": false, "mass_kg": 0.2, "at": {"position_m": [0.4, 0, )" +
                std::to_string(0.04 + gap) + R"(]}}},
    "program": {"do": "wait", "seconds": 1}, "faults": [)" +
                faults + R"(], "expectations": [)" + expectations + "]}");
}

TEST(Contacts, AnObjectThatFallsOnAnotherIsSeen) {
  const RunReport report = run(ball(0.15, R"({"kind": "contacts", "only": []},
      {"kind": "contacts", "only": [["plate", "ball"]]},
      {"kind": "event", "source": "contact", "event": "contact", "at_most": 0},
      {"kind": "contact_force", "between": ["ball", "plate"], "below_N": 1e6})"));
  ASSERT_EQ(report.expectations.size(), 4u);
  EXPECT_FALSE(report.expectations[0].passed);
  EXPECT_THAT(report.expectations[0].measured, Names("ball", "plate"));
  EXPECT_GT(report.expectations[0].value, 100.0) << "N";
  EXPECT_NEAR(report.expectations[0].value, report.expectations[3].value, 1.0) << "the same force";
  EXPECT_TRUE(report.expectations[1].passed);
  EXPECT_FALSE(report.expectations[2].passed);
}

TEST(Contacts, TheFloorCounts) {
  Description description = ball(0.15, R"({"kind": "contacts", "only": []})");
  std::erase_if(description.objects, [](const ObjectEntry& one) { return one.name == "plate"; });
  const RunReport report = run(std::move(description));
  EXPECT_FALSE(report.expectations.at(0).passed);
  EXPECT_THAT(report.expectations.at(0).measured, Names("ball", "floor"));
}

/// What stands on something when the run begins has not begun to touch it, until it has parted.
TEST(Contacts, WhatStandsSinceTheStartCountsOnceItHasParted) {
  constexpr const char* kNothing = R"({"kind": "contacts", "only": []})";
  EXPECT_TRUE(run(ball(0.0, kNothing)).expectations.at(0).passed);
  EXPECT_TRUE(run(ball(0.001, kNothing)).expectations.at(0).passed) << "a millimetre above it";
  const RunReport thrown = run(
      ball(0.0, kNothing, R"({"do": "push", "at_s": 0.3, "body": "ball", "force_N": [0, 0, 40], "seconds": 0.01})"));
  EXPECT_FALSE(thrown.expectations.at(0).passed) << thrown.expectations.at(0).measured;
}

/// More pairs than any list was made for.
TEST(Contacts, ManyObjectsThatStandDoNotHideOneThatFalls) {
  std::string objects = R"("ball": {"shape": "sphere", "radius_m": 0.02, "fixed": false, "mass_kg": 0.2,
                                    "at": {"position_m": [0, 3, 0.3]}})";
  for (int i = 0; i < 300; ++i)
    objects += R"(, "cube )" + std::to_string(i) + R"(": {"shape": "box", "size_m": [0.02, 0.02, 0.02],
      "fixed": false, "mass_kg": 0.05, "at": {"position_m": [)" +
               std::to_string(1.0 + 0.05 * (i % 20)) + ", " + std::to_string(0.05 * (i / 20)) + ", 0.01]}}";
  const RunReport report = run(parsed(R"({"objects": {)" + objects + R"(}, "program": {"do": "wait", "seconds": 0.4},
      "expectations": [{"kind": "contacts", "only": []}]})"));
  ASSERT_EQ(report.expectations.size(), 1u) << report.diagnostics.to_string();
  EXPECT_THAT(report.expectations[0].measured, Names("ball", "floor"));
  EXPECT_THAT(report.expectations[0].measured, testing::Not(Names("cube 7", "floor")));
}

// -- Forces ----------------------------------------------------------------------------------------------------------

/// A gripper closes on a part that stands between its fingers.
Description gripped(const std::string& expectations) {
  return parsed(R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "gripper": {"model": "wsg50", "on": "arm"}},
    "objects": {
      "table": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}},
      "part": {"shape": "box", "size_m": [0.04, 0.04, 0.06], "at": {"position_m": [0.55, 0, 0.23]}, "fixed": false,
               "mass_kg": 0.5}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "part", "position_m": [0, 0, 0.1], "rpy_deg": [180, 0, 0]}},
      {"do": "lin", "to": {"in": "part", "position_m": [0, 0, 0.01]}},
      {"do": "grip", "force_N": 80, "part": "part"},
      {"do": "wait", "name": "held", "seconds": 0.3}]},
    "expectations": [)" +
                expectations + "]}");
}

TEST(Forces, FingersThatPressAgainstEachOtherDoNotCancel) {
  const RunReport report = run(gripped(R"(
      {"kind": "contact_force", "between": ["gripper", "part"], "below_N": 20},
      {"kind": "contact_force", "between": ["gripper", "part"], "force": "pressing", "below_N": 20, "during": "held"},
      {"kind": "contact_force", "between": ["gripper", "part"], "force": "resultant", "below_N": 20, "during": "held"},
      {"kind": "contact_force", "between": ["gripper/finger_left", "part"], "below_N": 20},
      {"kind": "mean_force", "between": ["gripper", "part"], "at_least_N": 0, "below_N": 20})"));
  ASSERT_EQ(report.expectations.size(), 5u) << report.diagnostics.to_string();
  const double finger = report.expectations[3].value;
  EXPECT_GT(finger, 35.0) << "N";
  EXPECT_LT(finger, 50.0);
  for (const std::size_t pressing : {0, 1, 3, 4}) EXPECT_FALSE(report.expectations[pressing].passed) << pressing;
  EXPECT_NEAR(report.expectations[0].value, finger, 5.0) << "what the part feels from one side";
  EXPECT_TRUE(report.expectations[2].passed) << report.expectations[2].measured;
}

/// A sensor that nobody has heard says nothing about a peak; nor does one that is lost for a part of the time.
TEST(Forces, APeakIsOneOfAllReadings) {
  const auto peak = [](const std::string& faults) {
    return run(parsed(R"({"devices": {"arm": {"model": "lwr4plus"}, "wrist": {"model": "ft_gamma", "on": "arm"}},
      "program": {"do": "wait", "seconds": 0.5}, "faults": [)" +
                      faults + R"(], "expectations": [{"kind": "peak_force", "sensor": "wrist", "below_N": 1000}]})"))
        .expectations.at(0);
  };
  EXPECT_TRUE(peak("").passed) << peak("").measured;
  for (const char* fault : {R"("fault": "silent")", R"("fault": "nan")", R"("fault": "loss", "share": 0.3)",
                            R"("fault": "silent", "seconds": 0.05)", R"("fault": "nan", "seconds": 0.05)"})
    for (const char* begin : {"0", "0.2"}) {
      const auto judged =
          peak(R"({"do": "sensor", "sensor": "wrist", "at_s": )" + std::string(begin) + ", " + fault + "}");
      EXPECT_FALSE(judged.passed) << fault << " from " << begin << " s: " << judged.measured;
    }
}

// -- Ends ------------------------------------------------------------------------------------------------------------

TEST(Ends, AnArmThatStandsInAProtectiveStopHasNotPassed) {
  const RunReport report = run(parsed(R"({"devices": {"arm": {"model": "lwr4plus"}},
    "program": {"do": "wait", "seconds": 0.5},
    "faults": [{"do": "push", "body": "arm/link7", "at_s": 0.1, "seconds": 0.02, "force_N": [0, 250, 0]}]})"));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_EQ(exit_status(report.verdict), 3);
  EXPECT_THAT(report.diagnostics, Reports(Code::kDeviceFault, "/devices/arm", {"arm"}));
}

TEST(Ends, NorHasOneUnderAnEmergencyStop) {
  const RunReport report = run(parsed(R"({"devices": {"arm": {"model": "lwr4plus"}},
    "program": {"do": "wait", "seconds": 0.5}, "faults": [{"do": "emergency_stop", "at_s": 0.2}]})"));
  EXPECT_EQ(report.verdict, Verdict::kError);
}

TEST(Ends, AWindowThatEndsBeforeItBeginsIsRefused) {
  for (const char* kind : {R"json("kind": "event", "event": "begin", "times": 0)json",
                           R"json("kind": "value", "value": "$time()", "at_least": 0)json"})
    EXPECT_THAT(refusal(parsed(R"({"program": {"do": "wait", "seconds": 0.1}, "expectations": [{)" + std::string(kind) +
                               R"(, "from_s": 5, "to_s": 1}]})")),
                Reports(Code::kConflict, "/expectations/0/from_s", {"5", "1"}));
}

/// A value may settle first: what it did until then does not count, each time that its step begins.
TEST(Ends, AValueMayCountFromAWhileAfterItsStepHasBegun) {
  const auto judged = [](const std::string& window) {
    return run(parsed(R"json({"program": {"do": "sequence", "steps": [
        {"do": "wait", "seconds": 0.5}, {"do": "wait", "name": "hold", "seconds": 0.6}]},
      "expectations": [{"kind": "value", "value": "$time()", "during": "hold", "at_least": 0.8)json" +
                      window + "}]}"))
        .expectations.at(0);
  };
  EXPECT_FALSE(judged("").passed);
  EXPECT_TRUE(judged(R"(, "from_s": 0.35)").passed) << judged(R"(, "from_s": 0.35)").measured;
  EXPECT_FALSE(judged(R"(, "from_s": 0.2, "to_s": 0.5)").passed);
  EXPECT_FALSE(judged(R"(, "from_s": 0.7)").passed) << "the step is shorter";
}

// -- What is refused -------------------------------------------------------------------------------------------------

Description grip_of(const std::string& fixed, const std::string& grip) {
  return parsed(R"({"devices": {"arm": {"model": "ur5"}, "gripper": {"model": "wsg50", "on": "arm"}},
    "objects": {"part": {"shape": "box", "size_m": [0.04, 0.04, 0.06], "at": {"position_m": [0.45, 0.1, 0.03]}, )" +
                fixed + R"(}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "part", "position_m": [0, 0, 0.1], "rpy_deg": [180, 0, 0]}},
      {"do": "lin", "to": {"by_m": [0, 0, -0.1]}}, )" +
                grip + R"(, {"do": "lin", "to": {"by_m": [0, 0, 0.1]}}]}})");
}

TEST(Refused, WhatIsFixedIsNotGrippedWithItsNameOrWithout) {
  const std::string free = R"("fixed": false, "mass_kg": 0.3)", fixed = R"("fixed": true)";
  EXPECT_FALSE(refusal(grip_of(free, R"({"do": "grip"})")).has_errors());
  EXPECT_THAT(refusal(grip_of(fixed, R"({"do": "grip", "part": "part"})")),
              Reports(Code::kConflict, "/program/steps/2/part", {"part"}));
  EXPECT_THAT(refusal(grip_of(fixed, R"({"do": "grip"})")), Reports(Code::kConflict, "/program/steps/2", {"part"}));
}

/// Each of two grippers may say what the part weighs, or its share of it; what is neither is seen before the run.
TEST(Refused, APartHasOneMassHoweverManyHoldIt) {
  const auto told = [](const char* left, const char* right) {
    auto description = read_description(
        "scenarios/lessons/15-two-arms.json",
        {{"/program/steps/3/branches/0/part_mass_kg", left}, {"/program/steps/3/branches/1/part_mass_kg", right}});
    EXPECT_TRUE(description) << description.error().to_string();
    return std::move(*description);
  };
  EXPECT_FALSE(refusal(told("0.5", "0.5")).has_errors());
  EXPECT_FALSE(refusal(told("1", "1")).has_errors());
  EXPECT_EQ(run(told("1", "1")).verdict, Verdict::kPassed);
  EXPECT_THAT(refusal(told("0.5", "1")),
              Reports(Code::kPayloadMismatch, "/program/steps/3/branches/1/part_mass_kg", {"bar", "1", "1.5"}));
}

TEST(Refused, AFilmShowsASensorThatIsThere) {
  EXPECT_THAT(refusal(parsed(R"({"devices": {"arm": {"model": "ur5"}, "wrist": {"model": "ft_gamma", "on": "arm"}},
    "film": {"force_sensor": "wirst"}, "program": {"do": "wait", "seconds": 0.1}})")),
              Reports(Code::kUnknownName, "/film/force_sensor", {"wirst", "wrist"}));
}

/// An arm whose device file has no torque sensors feels nothing that a sensor could be made of.
TEST(Refused, AnArmWithoutTorqueSensorsHasNoForceOfItsOwn) {
  namespace fs = std::filesystem;
  const auto folder = TemporaryFolder::create();
  ASSERT_TRUE(folder);
  fs::copy("models/ur5", folder->path() / "ur5", fs::copy_options::recursive);
  const fs::path file = folder->path() / "ur5" / "device.json";
  auto device = *read_json(file);
  device["sensors"].erase("torque");
  std::ofstream(file) << device;
  const auto open = [&](const device::ModelLibrary& library) {
    const auto session = Session::create(parsed(R"({"devices": {"arm": {"model": "ur5", "own_force": "felt"}},
        "program": {"do": "tare", "sensor": "felt"}})"),
                                         library);
    return session ? Diagnostics() : session.error();
  };
  EXPECT_FALSE(open(test::models()).has_errors());
  EXPECT_THAT(open(device::ModelLibrary({folder->path(), "models"})),
              Reports(Code::kUnsupported, "/devices/arm/own_force", {"arm", "ur5"}));
}

/// One wrong name is one error: the sensor that the step names is on its arm.
TEST(Refused, AWrongCameraAddsNoErrorOfItsOwnAboutASensor) {
  Diagnostics diagnostics;
  const Description description = parsed(R"({
    "devices": {"arm": {"model": "lwr4plus"}, "wrist": {"model": "ft_gamma", "on": "arm"},
                "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"plate": {"shape": "box", "size_m": [0.2, 0.2, 0.08], "at": {"position_m": [0.56, 0, 0.04]}}},
    "program": {"do": "lin", "to": {"by_m": [0, 0.08, 0]}, "velocity_m_s": 0.02,
                "force_offset": {"sensor": "wrist", "force_N": 8, "reach_m": 0.03}}})");
  const expression::Cell names = names_of_cell(description, test::models());
  EXPECT_EQ(names.sensors.at("wrist").arm, "arm");
  EXPECT_EQ(names.tools.at("probe").arm, "arm");
  const auto program = program::Program::parse(description.program, "/program", names, &description.programs);
  EXPECT_TRUE(program) << program.error().to_string();
}

/// What an arm meets that did not get where it should is no fault of the program.
TEST(Refused, AnArmThatDoesNotGetThereIsNotCheckedForCollisionsAfterwards) {
  const Diagnostics diagnostics = refusal(parsed(R"({
    "devices": {"arm": {"model": "ur5"}, "gripper": {"model": "wsg50", "on": "arm"}},
    "objects": {"block": {"shape": "box", "size_m": [0.04, 0.04, 0.04], "fixed": false, "mass_kg": 0.2,
                          "at": {"position_m": [2.4, 0.1, 0.02]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0], "rpy_deg": [180, 0, 0]}},
      {"do": "grip", "part": "block"},
      {"do": "ptp", "to": {"in": "world", "position_m": [0.5, 0.1, 0.1], "rpy_deg": [180, 0, 0]}}]}})"));
  EXPECT_THAT(diagnostics, Reports(Code::kUnreachable, "/program/steps/0/to"));
  for (const Diagnostic& one : diagnostics.list()) EXPECT_NE(one.code, Code::kCollision) << to_string(one);
}

}  // namespace
}  // namespace takt::cell::verdicts_test
