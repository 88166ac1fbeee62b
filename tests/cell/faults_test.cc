// What happens to the machines of a scenario, whatever its program does.
#include "cell/faults/faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/support/reports.h"

namespace takt::cell::faults_test {
namespace {

using takt::test::Reports;
using takt::test::ReportsAnywhere;
using testing::AllOf;

Result<Description> description_with(const std::string& faults) {
  return parse_description(R"({"devices": {"arm": {"model": "lwr4plus"}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"joints_deg": [60, -30, 0, 90, 0, -60, 0]}, "speed": 0.5},
      {"do": "ptp", "name": "back", "to": "home", "speed": 0.5}]},
    "faults": )" + faults + "}");
}

RunReport run(const std::string& faults) {
  static const device::ModelLibrary models({"models"});
  const auto description = description_with(faults);
  EXPECT_TRUE(description) << description.error().to_string();
  auto session = Session::create(*description, models);
  EXPECT_TRUE(session) << session.error().to_string();
  return (*session)->run({});
}

TEST(Faults, WithoutOneTheProgramEnds) { EXPECT_EQ(run("[]").verdict, Verdict::kPassed); }

TEST(Faults, S3_AnArmThatStopsByItselfEndsItsNetWithTheCause) {
  for (const int category : {0, 1, 2}) {
    const RunReport report =
        run(R"([{"at_s": 1, "do": "stop", "arm": "arm", "category": )" + std::to_string(category) + "}]");
    EXPECT_EQ(report.verdict, Verdict::kError) << category;
    EXPECT_THAT(report.diagnostics, Reports(Code::kStopped, "/program/steps/0", {"arm", std::to_string(category)}));
    EXPECT_NEAR(report.sim_time, 1.0, 0.05) << "the net ends in the cycle in which it is told";
  }
}

/// The tool of a soft arm while it is held, every cycle from 1 s on: way from where it was then, m.
std::vector<Eigen::Vector3d> ways_of_the_tool(const std::string& faults) {
  const auto description = parse_description(
      R"({"devices": {"arm": {"model": "lwr4plus"}, "wrist": {"model": "ft_gamma", "on": "arm"}}, "program":
      {"do": "sequence", "steps": [{"do": "control_mode", "mode": "cartesian_impedance"},
                                   {"do": "hold", "seconds": 5}]},
      "faults": )" +
      faults + "}");
  EXPECT_TRUE(description) << description.error().to_string();
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(*description, models);
  EXPECT_TRUE(session) << session.error().to_string();
  std::vector<Eigen::Vector3d> ways;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    const sim::World& world = *built.world;
    if (built.core->time() > kSecond) ways.push_back(world.body_pose(world.body("wrist/measuring")).translation());
    return true;
  };
  EXPECT_EQ((*session)->run(options).verdict, Verdict::kPassed);
  const Eigen::Vector3d from = ways.at(0);
  for (Eigen::Vector3d& way : ways) way -= from;
  return ways;
}

TEST(Faults, APushLeadsASoftArmAwayAsLongAsItLasts) {
  const auto ways = ways_of_the_tool(R"([
      {"at_s": 1.5, "do": "push", "body": "wrist/measuring", "force_N": [0, 10, 0], "seconds": 2},
      {"at_s": 2.5, "do": "push", "body": "wrist/measuring", "force_N": [0, 10, 0], "seconds": 1.0}])");
  const auto at = [&](double seconds) { return ways.at(static_cast<std::size_t>(1e3 * (seconds - 1.0))); };
  EXPECT_LT(at(1.45).norm(), 2e-4) << "nobody pushes";
  const double once = at(2.45).y(), twice = at(3.45).y();
  EXPECT_GT(once, 0.8 * 10.0 / 2000.0) << "what the spring of 2000 N/m says";
  EXPECT_LT(once, 1.5 * 10.0 / 2000.0);
  EXPECT_NEAR(twice, 2.0 * once, 0.1 * once) << "two of them";
  EXPECT_LT(at(4.9).norm(), 5e-4) << "and it comes back";
}

/// Why a cell with these faults does not run.
Diagnostics why(const std::string& faults) {
  const auto description = description_with(faults);
  if (!description) return description.error();
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(*description, models);
  return session ? Diagnostics() : session.error();
}

TEST(Faults, APushNamesItsBodyAndItsForce) {
  EXPECT_THAT(why(R"([{"at_s": 1, "do": "push"}])"),
              AllOf(Reports(Code::kMissing, "/faults/0", {"body"}), Reports(Code::kMissing, "/faults/0", {"force_N"})));
  EXPECT_THAT(why(R"([{"at_s": 1, "do": "push", "body": "arm/elbow", "force_N": [0, 0, 1]}])"),
              Reports(Code::kUnknownName, "/faults/0/body", {"arm/elbow", "DEVICE/LINK"}));
  EXPECT_THAT(why(R"([{"at_s": 1, "do": "push", "body": "arm/base", "force_N": [0, 1], "arm": "arm", "seconds": 0}])"),
              AllOf(Reports(Code::kWrongType, "/faults/0/force_N"), Reports(Code::kUnknownKey, "/faults/0/arm"),
                    Reports(Code::kOutOfRange, "/faults/0/seconds")));
}

TEST(Faults, LimitsAreThoseOfWhatIsSent) {
  const auto description = parse_description(R"({"devices": {"arm": {"model": "lwr4plus"}},
        "program": {"do": "ptp", "to": {"joints_deg": [60, -30, 0, 90, 0, -60, 0]}, "speed": 0.5},
        "faults": [{"at_s": 1, "do": "stop", "category": 0}],
        "expectations": [{"kind": "limits", "name": "inside"}]})");
  ASSERT_TRUE(description) << description.error().to_string();
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(*description, models);
  ASSERT_TRUE(session) << session.error().to_string();
  const RunReport report = (*session)->run({});
  EXPECT_EQ(report.verdict, Verdict::kError);
  ASSERT_EQ(report.expectations.size(), 1u);
  EXPECT_FALSE(report.expectations[0].judged) << report.expectations[0].measured << ": an arm that falls out gets none";
}

TEST(Faults, S4_AnEmergencyStopEndsTheNetAndNothingResumes) {
  const RunReport report = run(R"([{"at_s": 1, "do": "emergency_stop", "category": 1},
                                   {"at_s": 1.5, "do": "reset"}])");
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, ReportsAnywhere(Code::kStopped));
}

TEST(Faults, AButtonThatIsNeverPressedInTheWayOfNothing) {
  // Pressed after the program has ended: the latch is there and was reset before the program began.
  EXPECT_EQ(run(R"([{"at_s": 100, "do": "emergency_stop"}])").verdict, Verdict::kPassed);
}

TEST(Faults, WhatIsWrongIsFoundAtOnce) {
  EXPECT_THAT(why(R"([{"at_s": -1, "do": "stopp"}, {"at_s": 1, "do": "reset", "arm": "arm"}, 3,
                      {"do": "stop", "category": 3, "who": "arm"}])"),
              Reports(Code::kWrongType, "/faults/2"));
  EXPECT_THAT(why(R"([{"at_s": -1, "do": "stopp"}, {"at_s": 1, "do": "reset", "arm": "arm"},
                      {"do": "stop", "category": 3, "who": "arm"}])"),
              AllOf(Reports(Code::kOutOfRange, "/faults/0/at_s"), Reports(Code::kUnknownName, "/faults/0/do", {"stop"}),
                    Reports(Code::kUnknownKey, "/faults/1/arm"), Reports(Code::kMissing, "/faults/2", {"at_s"}),
                    Reports(Code::kOutOfRange, "/faults/2/category"), Reports(Code::kUnknownKey, "/faults/2/who")));
  const auto rest = parse_description(R"({"devices": {"arm": {"model": "lwr4plus"}},
      "program": {"do": "ptp", "to": {"joints_deg": [900, 0, 0, 0, 0, 0, 0]}}, "faults": [{"at_s": 1, "do": "stopp"}],
      "expectations": [{"kind": "limit"}]})");
  ASSERT_TRUE(rest) << rest.error().to_string();
  const auto all = Session::create(*rest, device::ModelLibrary({"models"}));
  ASSERT_FALSE(all);
  EXPECT_THAT(all.error(),
              AllOf(Reports(Code::kUnknownName, "/faults/0/do"), Reports(Code::kUnknownName, "/expectations/0/kind"),
                    ReportsAnywhere(Code::kOutOfRange)));
  EXPECT_THAT(why(R"([{"at_s": 1, "do": "emergency_stop", "category": 2, "brakes_after_s": 1}])"),
              Reports(Code::kConflict, "/faults/0/brakes_after_s"));
  EXPECT_THAT(why(R"([{"at_s": 1, "do": "stop", "arm": "amr"}])"),
              Reports(Code::kUnknownName, "/faults/0/arm", {"amr", "arm"}));
}

}  // namespace
}  // namespace takt::cell::faults_test
