// What happens to the machines of a scenario, whatever its program does.
#include "scenario/faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/session.h"

namespace takt::scenario {
namespace {

using testing::HasSubstr;

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
    EXPECT_THAT(report.findings.to_string(), HasSubstr("fault " + std::to_string(5 + category)));
    EXPECT_NEAR(report.sim_time, 1.0, 0.05) << "the net ends in the cycle in which it is told";
  }
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
  EXPECT_TRUE(report.expectations[0].passed) << report.expectations[0].measured << ": an arm that falls out gets none";
}

TEST(Faults, S4_AnEmergencyStopEndsTheNetAndNothingResumes) {
  const RunReport report = run(R"([{"at_s": 1, "do": "emergency_stop", "category": 1},
                                   {"at_s": 1.5, "do": "reset"}])");
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.findings.to_string(), HasSubstr("stopped"));
}

TEST(Faults, AButtonThatIsNeverPressedInTheWayOfNothing) {
  // Pressed after the program has ended: the latch is there and was reset before the program began.
  EXPECT_EQ(run(R"([{"at_s": 100, "do": "emergency_stop"}])").verdict, Verdict::kPassed);
}

TEST(Faults, WhatIsWrongIsFoundAtOnce) {
  const auto wrong = description_with(R"([{"at_s": -1, "do": "stopp"}, {"at_s": 1, "do": "reset", "arm": "arm"},
                                          {"do": "stop", "category": 3, "who": "arm"}])");
  ASSERT_FALSE(wrong);
  const std::string text = wrong.error().to_string();
  for (const char* part : {"/faults/0/at_s", "did you mean 'stop'", "/faults/1/arm",
                           "/faults/2: error: key 'at_s' is missing", "/faults/2/category", "/faults/2/who"})
    EXPECT_THAT(text, HasSubstr(part));
  static const device::ModelLibrary models({"models"});
  const auto nobody = Session::create(*description_with(R"([{"at_s": 1, "do": "stop", "arm": "amr"}])"), models);
  ASSERT_FALSE(nobody);
  EXPECT_THAT(nobody.error().to_string(), HasSubstr("did you mean 'arm'"));
}

}  // namespace
}  // namespace takt::scenario
