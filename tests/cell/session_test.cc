// Whole runs of scenarios: what repeats, what changes the digest, how a run may end, and each expectation both ways.
#include "cell/run/session.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::session_test {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using takt::test::Warns;
using test::models;
using test::run;

/// scenarios/touch.json, without the second run that one of its expectations asks for: tests compare runs themselves.
Description touch(const std::vector<Override>& overrides = {}, std::uint64_t seed = 1) {
  auto description = read_description("scenarios/touch.json", overrides, seed);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  std::erase_if(description->expectations, [](const auto& one) { return one.kind == "repeats"; });
  return std::move(*description);
}

/// The arm of the touch scenario, moving a joint and back for a fraction of a second. `more` are keys of the scenario.
Description shorty(const std::string& more = "", const std::string& start = "[0, -30, 0, 90, 0, -60, 0]") {
  auto description = parse_description(R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": )" +
                                       start + R"(},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"block": {"shape": "box", "size_m": [0.1, 0.1, 0.1], "at": {"position_m": [0, 0.5, 0.05]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "name": "there", "to": {"joints_deg": [5, -30, 0, 90, 0, -60, 0]}},
      {"do": "wait", "name": "pause", "seconds": 0.05}]})" +
                                       more + "}");
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  return std::move(*description);
}

RunReport judged(const std::string& expectation) { return run(shorty(R"(, "expectations": [)" + expectation + "]")); }

// -- Touch ---------------------------------------------------------------------------------------------------------

TEST(Session, TouchPassesWhereverTheBlockLies) {
  for (const std::uint64_t seed : {1, 7, 42}) {
    const RunReport report = run(touch({}, seed));
    EXPECT_EQ(report.verdict, Verdict::kPassed) << "seed " << seed << "\n" << report.diagnostics.to_string();
    for (const auto& one : report.expectations) EXPECT_TRUE(one.passed) << "seed " << seed << ": " << one.measured;
  }
}

/// The controller knows nothing of a plant that is heavier than its URDF: it tracks worse, and touches elsewhere.
TEST(Session, D6_AHeavierPlantIsFeltButNotKnown) {
  const RunReport nominal = run(touch());
  const RunReport heavy = run(touch({{"/plant_mass_scale", "1.1"}}));
  const RunReport payload = run(touch({{"/devices/arm/payload_error_kg", "0.5"}}));
  for (const RunReport* other : {&heavy, &payload}) {
    EXPECT_NE(other->digest, nominal.digest);
    const std::string fitted = "block found";
    const auto found = other->estimates.find(fitted);
    ASSERT_NE(found, other->estimates.end()) << other->diagnostics.to_string();
    const double moved = (found->second.translation() - nominal.estimates.at(fitted).translation()).norm();
    EXPECT_GT(moved, 1e-7) << "the contacts are elsewhere";
    EXPECT_LT(moved, 1e-3) << "but not far";
  }
}

// -- Repetition ----------------------------------------------------------------------------------------------------

TEST(Session, D4_D5_TwoRunsAreEqualBitForBit) {
  const RunReport a = run(shorty()), b = run(shorty());
  EXPECT_EQ(a.verdict, Verdict::kPassed) << a.diagnostics.to_string();
  EXPECT_GT(a.cycles, 100);
  EXPECT_EQ(a.cycles, b.cycles);
  EXPECT_EQ(a.digest, b.digest);
  EXPECT_EQ(a.digest.size(), 32u);
}

TEST(Session, D5_MeasuringTimesChangesNoBit) {
  RunOptions without;
  without.measure_times = false;
  auto session = Session::create(shorty(), models(), true);
  ASSERT_TRUE(session.has_value());
  EXPECT_EQ((*session)->run({}).digest, run(shorty(), without).digest);
}

TEST(Session, D4_TheLowestBitOfOneJointChangesTheDigest) {
  Description changed = shorty();
  double& q = changed.devices[0].start_rad[1];
  q = std::nextafter(q, 0.0);
  EXPECT_NE(run(std::move(changed)).digest, run(shorty()).digest);
}

TEST(Session, D5_WhatIsEnteredLaterIsRepeatedFromThere) {
  auto session = Session::create(shorty(R"(, "expectations": [{"kind": "repeats"}])"), models());
  ASSERT_TRUE(session) << session.error().to_string();
  RunOptions options;
  options.from = "pause";
  const RunReport report = (*session)->run(options);
  ASSERT_EQ(report.expectations.size(), 1u);
  EXPECT_TRUE(report.expectations[0].passed) << report.expectations[0].measured;
}

TEST(Session, WarningsOfTheFileAreToldOnceAndOnlyIfNothingIsRefused) {
  const auto file = std::filesystem::path(testing::TempDir()) / "radians.json";
  std::ofstream(file) << R"({"devices": {"arm": {"model": "lwr4plus"}},
    "frames": {"a": {"rpy_deg": [0, 0, 1.5708]}},
    "program": {"do": "ptp", "to": {"joints_deg": [0, 0.5, 0, 1.5708, 0, 0, 0]}}})";
  const auto begun = [&](const std::string& from) {
    auto session = Session::open(file, models());
    EXPECT_TRUE(session) << session.error().to_string();
    EXPECT_THAT((*session)->warnings(), Warns(Code::kInvalidValue, "/frames/a/rpy_deg", {"1.5708"}));
    EXPECT_THAT((*session)->warnings(), Warns(Code::kInvalidValue, "/program/to/joints_deg", {"1.5708"}));
    EXPECT_EQ((*session)->warnings().list().size(), 2u) << (*session)->warnings().to_string();
    int count = 0;
    RunOptions options;
    options.from = from;
    options.begun = [&] { ++count; };
    EXPECT_TRUE((*session)->run(options).diagnostics.list().size() == (from.empty() ? 0u : 1u));
    return count;
  };
  EXPECT_EQ(begun(""), 1);
  EXPECT_EQ(begun("no such step"), 0) << "an option that is wrong is all that is told";
}

TEST(Session, ModelsBesideTheFileAreFound) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "with_models";
  fs::remove_all(folder);
  fs::create_directories(folder / "models" / "crate");
  std::ofstream(folder / "models/crate/device.json") << R"({"kind": "object", "name": "crate", "urdf": "crate.urdf"})";
  std::ofstream(folder / "models/crate/crate.urdf")
      << R"(<robot name="crate"><link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
            </link></robot>)";
  std::ofstream(folder / "a.json") << R"({"devices": {"arm": {"model": "lwr4plus"}},
      "objects": {"c": {"model": "crate", "at": {"position_m": [2, 0, 1]}}},
      "program": {"do": "wait", "seconds": 0.01}})";
  const auto session = Session::open(folder / "a.json", models());
  EXPECT_TRUE(session) << session.error().to_string();
  const auto unknown =
      Session::open(folder / "a.json", models(), {.overrides = {{"/objects/c/model", "crat"}}, .seed = {}});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error(), Reports(Code::kUnknownName, "/objects/c/model",
                                       {"crat", "crate", "youbot_base", (folder / "models").string(), "--models"}));
}

TEST(Session, UnknownKeysOfOtherOperationsAreExplained) {
  const auto wrong = Session::create(shorty(), models());
  ASSERT_TRUE(wrong);
  auto description = shorty();
  description.program["steps"][0]["velocity_m_s"] = 0.1;
  const auto session = Session::create(std::move(description), models());
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error(),
              Reports(Code::kUnknownKey, "/program/steps/0/velocity_m_s", {"lin", "circ", "ptp", "speed"}));
}

TEST(Session, AFrictionThatNeverDecidesIsNoted) {
  const auto with = [](const std::string& probe, const std::string& block) {
    auto description = shorty();
    description.devices.back().friction = probe.empty() ? std::nullopt : std::optional(std::stod(probe));
    description.objects.back().friction = block.empty() ? std::nullopt : std::optional(std::stod(block));
    auto session = Session::create(std::move(description), models());
    EXPECT_TRUE(session) << session.error().to_string();
    return (*session)->warnings();
  };
  EXPECT_THAT(with("", "0"), Notes("/objects/block/friction", {"0", "0.6"}));
  EXPECT_TRUE(with("", "0.9").empty()) << "it decides";
  EXPECT_TRUE(with("0.2", "0.2").empty()) << "both together do";
  EXPECT_THAT(with("0.2", "0.1"), Notes("/objects/block/friction", {"0.1", "0.2"}));
  EXPECT_THAT(with("0.1", ""), Notes("/devices/probe/friction", {"0.1", "0.6"}));
}

// -- Ends ----------------------------------------------------------------------------------------------------------

TEST(Session, D2_LatencyLengthensTheRunAndNothingElse) {
  const RunReport none = run(shorty(R"(, "program_latency_cycles": 0)"));
  const RunReport fifty = run(shorty(R"(, "program_latency_cycles": 50)"));
  EXPECT_EQ(none.verdict, Verdict::kPassed);
  EXPECT_EQ(fifty.verdict, Verdict::kPassed);
  EXPECT_EQ(fifty.cycles - none.cycles, 50) << "one motion";
}

TEST(Session, TheTimeLimitEndsTheRun) {
  const RunReport report = run(shorty(R"(, "time_limit_s": 0.1)"));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_NEAR(report.sim_time, 0.1, 1e-9);
  EXPECT_THAT(report.diagnostics, Reports(Code::kTimeout, "/time_limit_s", {"0.1 s", "there"}));
}

TEST(Session, AFirstInterruptEndsAtRest) {
  std::atomic<int> interrupt = 1;
  RunOptions options;
  options.interrupt = &interrupt;
  const RunReport before = run(shorty(), options);
  EXPECT_EQ(before.verdict, Verdict::kInterrupted);
  EXPECT_LT(before.cycles, 5) << "before the first step";
  // During the motion: the progress function is called now and then.
  interrupt = 0;
  options.realtime = true;
  options.progress = [&](double time, double, const std::string&) { interrupt = time > 0.05 ? 1 : 0; };
  auto session = Session::create(touch(), models());
  ASSERT_TRUE(session.has_value());
  const RunReport report = (*session)->run(options);
  EXPECT_EQ(report.verdict, Verdict::kInterrupted);
  EXPECT_LT(report.sim_time, 2.0);
  EXPECT_TRUE((*session)->built().cell.arms.at("arm").device->at_rest());
}

TEST(Session, ASecondInterruptStopsAtOnce) {
  std::atomic<int> interrupt = 2;
  RunOptions options;
  options.interrupt = &interrupt;
  const RunReport report = run(shorty(), options);
  EXPECT_EQ(report.verdict, Verdict::kInterrupted) << "not passed: nothing was run";
  EXPECT_EQ(report.cycles, 0);
}

TEST(Session, AFailingStepIsAnErrorWithItsPlace) {
  Description description = shorty();
  description.program["steps"].push_back(nlohmann::ordered_json::parse(
      R"({"do": "lin", "to": {"by_m": [0, 0, 0.01]}, "until": {"sensor": "wrist", "above_N": 500}})"));
  const RunReport report = run(std::move(description));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kConditionNotMet, "/program/steps/2/until"));
}

TEST(Session, WhatCannotRunIsRefusedBeforeAnythingMoves) {
  Description description = shorty(R"(, "expectations": [{"kind": "step", "step": "pauze"}, {"kind": "hope"}])");
  description.program["steps"].push_back(
      nlohmann::ordered_json::parse(R"({"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 9]}})"));
  description.film.cuts.push_back({"theer", "c"});
  const auto session = Session::create(std::move(description), models());
  ASSERT_FALSE(session.has_value());
  EXPECT_THAT(session.error(), testing::AllOf(Reports(Code::kUnreachable, "/program/steps/2/to"),
                                              Reports(Code::kUnknownName, "/expectations/0/step", {"pauze", "pause"}),
                                              Reports(Code::kUnknownName, "/expectations/1/kind", {"hope"}),
                                              Reports(Code::kUnknownName, "/film/cuts/0/step", {"theer"})));
}

// -- Expectations --------------------------------------------------------------------------------------------------

struct Judgement {
  const char* expectation;
  bool passed;
};

void PrintTo(const Judgement& judgement, std::ostream* out) { *out << judgement.expectation; }

class ExpectationTest : public testing::TestWithParam<Judgement> {};

TEST_P(ExpectationTest, IsJudged) {
  const RunReport report = judged(GetParam().expectation);
  ASSERT_EQ(report.expectations.size(), 1u) << report.diagnostics.to_string();
  EXPECT_EQ(report.expectations[0].passed, GetParam().passed) << report.expectations[0].measured;
  EXPECT_NE(report.expectations[0].measured, "");
  EXPECT_EQ(report.verdict, GetParam().passed ? Verdict::kPassed : Verdict::kFailed);
}

constexpr Judgement kJudgements[] = {
    {R"({"kind": "duration", "below_s": 10})", true},
    {R"({"kind": "duration", "below_s": 0.1})", false},
    {R"({"kind": "limits", "arm": "arm"})", true},
    {R"({"kind": "step", "step": "pause"})", true},
    {R"({"kind": "repeats"})", true},
    {R"({"kind": "mean_force", "between": ["probe", "block"], "at_least_N": 0, "below_N": 50})", false},  // no touch
    {R"({"kind": "peak_force", "sensor": "wrist", "below_N": 50})", true},
    {R"({"kind": "peak_force", "sensor": "wrist", "below_N": 0.01})", false},
    {R"({"kind": "contact_force", "between": ["probe", "block"], "below_N": 1})", true},
    {R"({"kind": "contact_force", "between": ["probe", "block"], "below_N": 10, "at_least_N": 1})", false},
    {R"({"kind": "object_pose", "object": "block", "position_m": [0, 0.5, 0.05], "position_within_m": 0.001})", true},
    {R"({"kind": "object_pose", "object": "block", "position_m": [0, 0.5, 0.06], "position_within_m": 0.001})", false},
    {R"({"kind": "object_pose", "object": "block", "position_m": [0, 0.5, 0.05], "rpy_deg": [0, 0, 3],
         "position_within_m": 0.001, "angle_within_deg": 1})",
     false},
};
INSTANTIATE_TEST_SUITE_P(Each, ExpectationTest, testing::ValuesIn(kJudgements));

TEST(Session, AStepThatNeverRanFailsItsExpectation) {
  Description description = shorty(R"(, "expectations": [{"kind": "step", "step": "skipped"}])");
  description.program["steps"].push_back(nlohmann::ordered_json::parse(
      R"({"do": "sequence", "times": 0, "steps": [{"do": "wait", "name": "skipped", "seconds": 1}]})"));
  const RunReport report = run(std::move(description));
  EXPECT_EQ(report.verdict, Verdict::kFailed);
  EXPECT_EQ(report.expectations.at(0).measured, "step 'skipped' ran 0 times");
}

}  // namespace
}  // namespace takt::cell::session_test
