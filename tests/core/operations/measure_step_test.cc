// Touching, recording, fitting: on an arm without a body that feels a block which is not where it is believed to be.
#include "core/operations/force/tare.h"

#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::ElementsAre;

class MeasureTest : public test::ActivityTest {
 protected:
  /// Moves the real block: m in the axes of its nominal frame, and rad about z.
  void displace(const Eigen::Vector3d& by, double yaw) {
    const Eigen::Isometry3d X_WN = *fake.cell.frames.pose("block");
    fake.X_WO_true = X_WN * Eigen::Translation3d(by) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  }
  static double angle(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
  }
};

constexpr const char* kTouchTop = R"({"do": "sequence", "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.04]}},
    {"do": "tare", "cycles": 50},
    {"do": "lin", "to": {"by_m": [0, 0, -0.025]}, "velocity_m_s": 0.02,
     "until": {"sensor": "wrist", "above_N": 5}},
    {"do": "record_contact", "as": "top"}]})";

/// Top, long side twice, short side: what the scenario "touch" does.
constexpr const char* kTouchAndFit = R"({"do": "sequence", "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.04]}},
    {"do": "tare", "cycles": 50},
    {"do": "lin", "to": {"by_m": [0, 0, -0.025]}, "velocity_m_s": 0.02,
     "until": {"sensor": "wrist", "above_N": 5}},
    {"do": "record_contact", "as": "top"},
    {"do": "lin", "to": {"by_m": [0, 0, 0.03]}},
    {"do": "ptp", "to": {"in": "block", "position_m": [-0.03, -0.06, 0.05]}},
    {"do": "lin", "to": {"in": "block", "position_m": [-0.03, -0.06, 0.005]}},
    {"do": "lin", "to": {"by_m": [0, 0.05, 0], "in": "block"}, "velocity_m_s": 0.02,
     "until": {"sensor": "wrist", "above_N": 5}},
    {"do": "record_contact", "as": "left"},
    {"do": "lin", "to": {"in": "block", "position_m": [-0.03, -0.06, 0.005]}},
    {"do": "lin", "to": {"in": "block", "position_m": [0.03, -0.06, 0.005]}},
    {"do": "lin", "to": {"by_m": [0, 0.05, 0], "in": "block"}, "velocity_m_s": 0.02,
     "until": {"sensor": "wrist", "above_N": 5}},
    {"do": "record_contact", "as": "right"},
    {"do": "lin", "to": {"in": "block", "position_m": [0.03, -0.06, 0.005]}},
    {"do": "lin", "to": {"in": "block", "position_m": [0.03, -0.06, 0.06]}},
    {"do": "ptp", "to": {"in": "block", "position_m": [-0.08, 0, 0.06]}},
    {"do": "lin", "to": {"in": "block", "position_m": [-0.08, 0, 0.005]}},
    {"do": "lin", "to": {"by_m": [0.05, 0, 0], "in": "block"}, "velocity_m_s": 0.02,
     "until": {"sensor": "wrist", "above_N": 5}},
    {"do": "record_contact", "as": "short"},
    {"do": "lin", "to": {"in": "block", "position_m": [-0.08, 0, 0.005]}},
    {"do": "lin", "to": {"in": "block", "position_m": [-0.08, 0, 0.07]}},
    {"do": "fit_pose", "object": "block", "as": "found", "contacts": ["top", "left", "right", "short"],
     "free": ["x", "y", "z", "yaw"]},
    {"do": "ptp", "to": {"in": "found", "position_m": [0, 0, 0.07]}}]})";

TEST_F(MeasureTest, ATouchIsRecordedWhereItWasFelt) {
  displace({0, 0, 0.002}, 0);
  ASSERT_EQ(run(std::string(kTouchTop)), Progress::kDone) << diagnostics.to_string();
  const Eigen::Vector3d p_O = fake.X_WO_true.inverse() * variables.contacts.at("top").p_R;
  EXPECT_EQ(variables.contacts.at("top").radius, 0.005);
  // 5 N are felt 5 um deep, and in a cycle the ball goes 20 um further.
  EXPECT_LT(p_O.z(), 0.025 + 0.005);
  EXPECT_GT(p_O.z(), 0.025 + 0.005 - 50e-6);
  EXPECT_THAT(log, testing::Contains(testing::StartsWith("arm: touch (")));
}

TEST_F(MeasureTest, TheWholeMeasurementFindsTheBlock) {
  const program::Program program = good(kTouchAndFit);
  for (const auto& [by, yaw] :
       {std::pair<Eigen::Vector3d, double>{{0.008, -0.006, 0.003}, 0.07}, {{-0.01, 0.009, -0.002}, -0.08}}) {
    displace(by, yaw);
    ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
    const Eigen::Isometry3d found = variables.estimates.at("found");
    EXPECT_LT((found.translation() - fake.X_WO_true.translation()).norm(), 100e-6);
    EXPECT_LT(angle(found, fake.X_WO_true), 2e-3);
    EXPECT_LT(variables.residuals.at("found"), 1e-3);
    EXPECT_TRUE(fake.cell.frames.pose("found")->isApprox(found, 1e-12)) << "it is a frame now";
    EXPECT_LT((fake.tool_in_world(fake.q()).translation() - found * Eigen::Vector3d(0, 0, 0.07)).norm(), 1e-6);
  }
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

/// From a command to its effect some cycles pass: the program takes longer, what it finds stays the same.
TEST_F(MeasureTest, D2_LatencyChangesNoResult) {
  std::vector<int> durations;
  for (const std::int64_t cycles_of_latency : {0, 1, 2, 7, 50}) {
    test::FakeCell fresh;
    const Eigen::Isometry3d X_WN = *fresh.cell.frames.pose("block");
    fresh.X_WO_true =
        X_WN * Eigen::Translation3d(0.008, -0.006, 0.003) * Eigen::AngleAxisd(0.07, Eigen::Vector3d::UnitZ());
    activity::Variables known;
    activity::Context context{fresh.cell, fresh.core, known, cycles_of_latency, [](auto, auto, auto) {}};
    const program::Program program = good(kTouchAndFit);
    program::ProgramRunner runner(program, context);
    int count = 0;
    while (runner.advance() == Progress::kRunning && ++count < 100'000) fresh.step();
    ASSERT_EQ(runner.progress(), Progress::kDone) << runner.diagnostics().to_string();
    EXPECT_LT((known.estimates.at("found").translation() - fresh.X_WO_true.translation()).norm(), 100e-6);
    durations.push_back(count);
  }
  EXPECT_EQ(durations.back() - durations.front(), 50 * 18) << "50 cycles for each of the 18 motions and tares";
}

TEST_F(MeasureTest, TareTakesTheBiasAndNotTheWeight) {
  ASSERT_EQ(run(std::string(R"({"do": "tare"})")), Progress::kDone) << diagnostics.to_string();
  EXPECT_LT((variables.biases.at("wrist").force - fake.bias.force).norm(), 1e-9);
  EXPECT_LT((variables.biases.at("wrist").torque - fake.bias.torque).norm(), 1e-9);
}

TEST_F(MeasureTest, TareOfASilentSensorFails) {
  fake.sensor->silent = true;
  EXPECT_EQ(run(std::string(R"({"do": "tare"})")), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/sensor", {"wrist"}));
  EXPECT_LT(cycles, 1000);
}

TEST_F(MeasureTest, WithoutATouchThereIsNoContact) {
  const std::string missed = R"({"do": "sequence", "steps": [
    {"do": "tare", "cycles": 50},
    {"do": "lin", "to": {"by_m": [0, 0, 0.02]}, "until": {"sensor": "wrist", "above_N": 5}, "on_end": "continue"},
    {"do": "record_contact", "as": "air"}]})";
  EXPECT_EQ(run(missed), Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/2"));
  EXPECT_THAT(diagnostics, Reports(Code::kNoContact, "/program/steps/2"));
}

TEST_F(MeasureTest, ATouchIsForgottenByTheNextMotion) {
  std::string twice(kTouchTop);
  twice.insert(twice.rfind("]}"),
               R"(, {"do": "lin", "to": {"by_m": [0, 0, 0.02]}}, {"do": "record_contact", "as": "again"})");
  EXPECT_EQ(run(twice), Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/5"));
}

TEST_F(MeasureTest, AFitWithoutItsContactsFails) {
  EXPECT_EQ(
      run(std::string(R"({"do": "fit_pose", "object": "block", "as": "f", "contacts": ["a", "b"], "free": ["z"]})")),
      Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/contacts", "/program/contacts"));
  EXPECT_FALSE(fake.cell.frames.contains("f"));
}

TEST_F(MeasureTest, AFitThatExplainsNothingFails) {
  variables.contacts["a"] = {"a", fake.X_WO_true * Eigen::Vector3d(0, 0, 0.5), 0.005};
  variables.contacts["b"] = {"b", fake.X_WO_true * Eigen::Vector3d(0, 0, 0.2), 0.005};
  EXPECT_EQ(
      run(std::string(R"({"do": "fit_pose", "object": "block", "as": "f", "contacts": ["a", "b"], "free": ["z"]})")),
      Progress::kFailed);
  EXPECT_TRUE(variables.estimates.empty());
}

}  // namespace
}  // namespace takt::operations
