// Scenarios on a UR5 behind its driver, with the emulated controller in the process.
#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "hw/drivers.h"
#include "tests/support/reports.h"

namespace takt::cell {
namespace {

/// There and back on a line, from home.
const std::string kUrMotion = R"({
  "devices": {"arm": {"model": "ur5", "at": {"in": "world"}}},
  "program": {"do": "sequence", "steps": [
    {"do": "ptp", "to": "home"},
    {"do": "lin", "to": {"by_m": [0, 0.05, -0.05]}, "speed": 0.3},
    {"do": "lin", "to": {"by_m": [0, -0.05, 0.05]}, "speed": 0.3},
    {"do": "wait", "seconds": 0.3}
  ]}
})";

/// A touch that the arm's own force ends.
const std::string kUrTouch = R"({
  "devices": {"arm": {"model": "ur5", "own_force": "felt", "at": {"in": "world"}},
              "probe": {"model": "probe_ball", "on": "arm"}},
  "objects": {"block": {"shape": "box", "size_m": [0.2, 0.2, 0.2], "at": {"position_m": [0.5, 0.1, 0.1]}}},
  "program": {"do": "sequence", "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.13], "rpy_deg": [0, 180, 0]}},
    {"do": "wait", "seconds": 0.5},
    {"do": "tare", "sensor": "felt"},
    {"do": "lin", "to": {"by_m": [0, 0, -0.06]}, "velocity_m_s": 0.01, "until": {"sensor": "felt", "above_N": 15}},
    {"do": "lin", "to": {"by_m": [0, 0, 0.02]}}
  ]},
  "expectations": [{"kind": "contact_force", "between": ["probe", "block"], "below_N": 40, "at_least_N": 8}]
})";

struct UrRun {
  RunReport report;
  std::vector<device::JointVector> q;  // of the plant, each cycle
};

UrRun run_ur(const std::vector<std::string>& backends, std::uint64_t seed = 1, const std::string& text = kUrMotion) {
  static const device::ModelLibrary library({"models"});
  hw::add_own_drivers();
  Site site;
  for (const std::string& backend : backends) {
    const Diagnostics diagnostics = cell::bind(site, backend);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  }
  auto description = parse_description(text, {}, seed);
  EXPECT_TRUE(description) << description.error().to_string();
  description->site = site;
  auto session = Session::create(std::move(*description), library);
  EXPECT_TRUE(session) << session.error().to_string();
  UrRun out;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    out.q.push_back(built.cell.arms.at("arm").device->sample().q);
    return true;
  };
  out.report = (*session)->run(options);
  return out;
}

/// How far joint positions of one run are from the nearest ones of another.
double farthest(const UrRun& a, const UrRun& b) {
  double most = 0.0;
  for (const device::JointVector& q : a.q) {
    if (q.size() == 0) continue;
    double nearest = 10.0;
    for (const device::JointVector& other : b.q)
      if (other.size() == q.size()) nearest = std::min(nearest, (q - other).cwiseAbs().maxCoeff());
    most = std::max(most, nearest);
  }
  return most;
}

TEST(RtdeRun, AMotionThroughTheDriverIsTheSimulatedOne) {
  const UrRun direct = run_ur({}), driven = run_ur({"arm=rtde"});
  ASSERT_EQ(direct.report.verdict, Verdict::kPassed) << direct.report.diagnostics.to_string();
  ASSERT_EQ(driven.report.verdict, Verdict::kPassed) << driven.report.diagnostics.to_string();
  EXPECT_LE(farthest(direct, driven), 1e-3) << "rad";
  EXPECT_LE(farthest(driven, direct), 1e-3) << "rad";
  EXPECT_EQ(driven.report.site.realities.at("arm"), device::BackendMode::kEmulated);
}

TEST(RtdeRun, TheSameSeedGivesTheSameDigest) {
  const UrRun a = run_ur({"arm=rtde:virtual,jitter=1ms"}), b = run_ur({"arm=rtde:virtual,jitter=1ms"});
  ASSERT_EQ(a.report.verdict, Verdict::kPassed) << a.report.diagnostics.to_string();
  EXPECT_EQ(a.report.digest, b.report.digest);
}

TEST(RtdeRun, StatesOnTheWayUpAreNoErrors) {
  const UrRun run = run_ur({"arm=rtde"});
  ASSERT_EQ(run.report.verdict, Verdict::kPassed) << run.report.diagnostics.to_string();
  for (const LogEntry& entry : run.report.log) EXPECT_LT(entry.level, LogLevel::kWarning) << to_text(entry);
}

TEST(RtdeRun, TheVerdictSaysWhatTheDriverRefusedAndWhy) {
  const UrRun run = run_ur({"arm=rtde:virtual,robot=UR10"});
  EXPECT_EQ(run.report.verdict, Verdict::kError);
  EXPECT_THAT(run.report.diagnostics, takt::test::Reports(Code::kDeviceFault, "", {"arm", "UR5", "UR10"}));
}

/// The arm stops while nothing holds it; `faults` say what else happens before it is to move.
std::string stopped_before_a_motion(const std::string& faults) {
  return R"({
    "devices": {"arm": {"model": "ur5", "at": {"in": "world"}}},
    "program": {"do": "sequence", "steps": [
      {"do": "wait", "seconds": 9}, {"do": "lin", "to": {"by_m": [0, 0.05, -0.05]}}]},
    "faults": [{"at_s": 1, "do": "stop", "category": 1})" +
         faults + "]}";
}

TEST(RtdeRun, WhoResetsAnArmInAScenarioResetsItsDriver) {
  const UrRun reset = run_ur({"arm=rtde"}, 1, stopped_before_a_motion(R"(, {"at_s": 7, "do": "release"})"));
  EXPECT_EQ(reset.report.verdict, Verdict::kPassed) << reset.report.diagnostics.to_string();
  EXPECT_EQ(run_ur({"arm=rtde"}, 1, stopped_before_a_motion("")).report.verdict, Verdict::kError);
}

TEST(RtdeRun, SettingsThatCannotBeAreRefused) {
  hw::add_own_drivers();
  for (const auto& [setting, text] : std::vector<std::pair<std::string, std::string>>{
           {"arm=rtde:192.0.2.1:4000", "ports of a UR controller are fixed"},
           {"arm=rtde:nowhere", "address"},
           {"arm=rtde:virtual,series=f", "series"},
           {"arm=rtde:virtual,gain=5000", "gain"}}) {
    Site site;
    const Diagnostics diagnostics = cell::bind(site, setting);
    EXPECT_TRUE(diagnostics.has_errors()) << setting;
    EXPECT_THAT(diagnostics.to_string(), testing::HasSubstr(text));
  }
}

// What the controller reports ends the motion, not what the simulated joints say.
TEST(RtdeRun, AForceThatTheControllerReportsEndsAGuardedMotion) {
  for (const std::vector<std::string>& backends : {std::vector<std::string>{}, {"arm=rtde"}}) {
    const UrRun run = run_ur(backends, 1, kUrTouch);
    EXPECT_EQ(run.report.verdict, Verdict::kPassed) << run.report.diagnostics.to_string();
    for (const auto& one : run.report.expectations) EXPECT_TRUE(one.passed) << one.name << ": " << one.measured;
  }
}

}  // namespace
}  // namespace takt::cell
