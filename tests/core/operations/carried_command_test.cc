// An arm together with its base, as a command of a transaction: "lin" with "base_to" (rows P5, L6, C7).
#include "core/command/actions/carried_motion.h"
#include "core/command/actions/compliance_action.h"
#include "core/command/check.h"
#include "core/command/mapping.h"
#include "core/device/base_description.h"
#include "core/operations/table/goal.h"
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

/// The arm of the cell on a base that drives.
class CarriedCommandTest : public test::CommandStepTest {
 protected:
  CarriedCommandTest() : CommandStepTest(put_on_base) {}

  static void put_on_base(test::CommandCell& own) {
    const auto base = device::read_base("models/youbot_base");
    ASSERT_TRUE(base) << base.error().to_string();
    auto& mounted = own.cell.arms["base"];
    mounted.device = &own.core.add(std::make_unique<device::Arm>(
        "base", *base, std::make_shared<test::FakeArm>((*base)->home), own.core.period()));
    mounted.start = (*base)->home;
    Eigen::Isometry3d X_FA = Eigen::Isometry3d::Identity();
    X_FA.translation() << 0.143, 0.0, 0.1275;
    ASSERT_TRUE(own.cell.frames.add("base", "world", Eigen::Isometry3d::Identity()).empty());
    ASSERT_TRUE(
        own.cell.frames
            .set("arm", {.kind = world::Relation::Kind::kFlange, .parent = "base", .X_PF = X_FA, .source = "base"})
            .empty());
    own.X_WB = X_FA;
  }

  const device::Arm& base() const { return *cell.cell.arms.at("base").device; }
  /// By what was sent.
  Eigen::Isometry3d in_room() const {
    const Eigen::Isometry3d X_WF = base().description().chain->forward(base().set_point().q);
    return X_WF * cell.cell.frames.relation("arm")->X_PF * expression::tool_pose(cell.cell.arms.at("arm"), cell.q());
  }
  Eigen::Vector3d tool_in_room() const { return in_room().translation(); }
  double base_speed() const { return base().set_point().dq.cwiseAbs().maxCoeff(); }

  static std::string tree(const std::string& commands, const std::string& more = "") {
    return R"({"do": "transaction", "name": "t", "commands": {)" + commands + "}" + more + "}";
  }
  static constexpr const char* kStraight = R"("straight": {"do": "lin", "arm": "arm", "start": true,
      "to": {"in": "world", "by_m": [0.5, 0.3, 0.1]}, "base_to": {"by_m": [0.4, 0.5, 0], "by_rpy_deg": [0, 0, 20]}})";
  static double off_line(const Eigen::Vector3d& p, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector3d along = (to - from).normalized();
    return (p - from - along.dot(p - from) * along).norm();
  }
  void expect_both_free() {
    expect_good_end();
    EXPECT_TRUE(base().at_rest());
    EXPECT_FALSE(base().held());
  }
};

const Eigen::Vector3d kWay(0.5, 0.3, 0.1);

TEST_F(CarriedCommandTest, TheToolGoesStraightWhileTheBaseDrivesAndASignalIsSet) {
  const Eigen::Vector3d from = tool_in_room();
  double off = 0.0, lit = -1.0;
  const program::Program program =
      good(tree(std::string(kStraight) + R"(, "lamp": {"do": "set", "output": "lamp", "value": true},
          "driver": {"do": "set", "start": true, "output": "driver", "value": true})",
                R"(, "on": [{"entered": {"action": "straight", "at_path": 0.5}, "start": "lamp"}])"));
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner&) {
                  off = std::max(off, off_line(tool_in_room(), from, from + kWay));
                  if (lamp() && lit < 0.0) lit = (tool_in_room() - from).norm() / kWay.norm();
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(off, 1e-9);
  EXPECT_LT((tool_in_room() - from - kWay).norm(), 1e-8);
  EXPECT_LT((base().set_point().q - Eigen::Vector3d(0.4, 0.5, 20.0 * std::numbers::pi / 180.0)).norm(), 1e-9);
  EXPECT_NEAR(lit, 0.5, 0.02);
  EXPECT_TRUE(driver());
  expect_both_free();
}

TEST_F(CarriedCommandTest, AHandlerThatCancelsStopsBothOnTheLine) {
  const Eigen::Vector3d from = tool_in_room();
  double off = 0.0;
  int apart = 0;
  const program::Program program = good(tree(kStraight, R"(, "on": [{"entered": {"action": "straight", "at_path": 0.4},
      "cancel": "straight"}], "capture": {"way": {"value": {"progress": "straight"},
      "when": {"cancelled": "straight"}}})"));
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner&) {
                  off = std::max(off, off_line(tool_in_room(), from, from + kWay));
                  apart += (base_speed() < 1e-12) != (speed() < 1e-12);
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(off, 1e-9);
  EXPECT_EQ(apart, 0) << "both move, or both stand";
  EXPECT_NEAR(std::stod(variables.monitors["t"]["way"]), 0.4, 0.01);
  const double way = (tool_in_room() - from).norm() / kWay.norm();
  EXPECT_GT(way, 0.4);
  EXPECT_LT(way, 0.9);
  expect_both_free();
}

/// Where a goal in the room lies to an arm is planned with the base where it is by then.
TEST_F(CarriedCommandTest, GoalsInTheRoomAreSeenFromWhereTheBaseWillBe) {
  const Eigen::Vector3d from = tool_in_room(), there = from + Eigen::Vector3d(0.35, 0.1, 0.05);
  const std::string to = fmt::format(R"("to": {{"in": "world", "position_m": [{:.17g}, {:.17g}, {:.17g}],
      "rpy_deg": [0, 180, 0]}})",
                                     there.x(), there.y(), there.z());
  ASSERT_EQ(run(tree(R"("drive": {"do": "lin", "arm": "base", "start": true, "to": {"by_m": [0.3, 0.1, 0]}},
      "straight": {"do": "lin", "arm": "arm", "base_to": {"by_m": [0.1, -0.2, 0], "by_rpy_deg": [0, 0, 15]}, )" +
                         to + R"(}, "up": {"do": "lin", "arm": "arm", "to": {"by_m": [0, 0, 0.05]}},
      "again": {"do": "ptp", "arm": "arm", )" +
                         to + "}",
                     R"(, "on": [{"entered": {"completed": "drive"}, "start": "straight"},
                                 {"entered": {"completed": "straight"}, "start": "up", "tell": "there"},
                                 {"entered": {"completed": "up"}, "start": "again"}])")),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT((base().set_point().q.head<2>() - Eigen::Vector2d(0.4, -0.1)).norm(), 1e-9);
  EXPECT_LT((tool_in_room() - there).norm(), 1e-6);
  expect_both_free();
}

TEST_F(CarriedCommandTest, AGoalInTheRoomIsRefusedWhereNobodyKnowsWhereTheBaseWillBe) {
  const auto after = [](const std::string& goal) {
    return tree(R"("drive": {"do": "lin", "arm": "base", "start": true, "to": {"by_m": [0.3, 0, 0]},
                             "abort_if": {"input": "button"}},
                   "reach": {"do": "lin", "arm": "arm", "to": )" +
                    goal + "}",
                R"(, "on": [{"entered": {"completed": "drive"}, "start": "reach"}])");
  };
  const Diagnostics found = wrong(after(R"({"in": "world", "position_m": [0.6, 0, 0.5], "rpy_deg": [0, 180, 0]})"));
  ASSERT_EQ(found.list().size(), 1u) << found.to_string();
  EXPECT_EQ(found.list().front().pointer, "/program/commands/reach/to");
  EXPECT_THAT(found, Reports(Code::kInvalidValue, "/program/commands/reach/to", {"arm", "base"}));
  EXPECT_FALSE(wrong(after(R"({"by_m": [0, 0, 0.05], "in": "tcp"})")).has_errors()) << "that does not hang on it";
}

TEST_F(CarriedCommandTest, C7_NothingElseMovesArmOrBaseAtTheSameTime) {
  for (const char* device : {"base", "arm"}) {
    const std::string other = fmt::format(R"(, "other": {{"do": "lin", "start": true, "arm": "{}",
        "to": {{"by_m": [0.1, 0, 0]}}}})",
                                          device);
    EXPECT_THAT(wrong(tree(kStraight + other)),
                Reports(Code::kResourceConflict, "/program/commands/other", {"C7", device, "/t/straight"}));
  }
}

TEST_F(CarriedCommandTest, L6_ACancelAtAnyCycleStopsBothOnTheLine) {
  const program::Program program = good(tree(kStraight));
  const program::Program home = good(R"({"do": "sequence", "steps": [{"do": "lin", "arm": "base", "to": "home"},
                                                           {"do": "ptp", "arm": "arm", "to": "home"}]})");
  ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
  const int whole = cycles;
  ASSERT_EQ(run(home), Progress::kDone) << diagnostics.to_string();
  const Eigen::Vector3d from = tool_in_room();
  for (int at = 1; at < whole; at += whole / 9) {
    SCOPED_TRACE(at);
    double off = 0.0;
    ASSERT_EQ(run(program,
                  [&](int cycle, program::ProgramRunner& runner) {
                    if (cycle == at) runner.cancel();
                    off = std::max(off, off_line(tool_in_room(), from, from + kWay));
                  }),
              Progress::kDone);
    EXPECT_LT(off, 1e-9);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
    ASSERT_EQ(run(home), Progress::kDone) << "they are free again: " << diagnostics.to_string();
    EXPECT_LT((tool_in_room() - from).norm(), 1e-9);
  }
  expect_both_free();
}

TEST_F(CarriedCommandTest, AGuardedLineStopsBothAndTellsWhereItTouched) {
  const Eigen::Vector3d from = tool_in_room();
  std::string guarded = kStraight;
  guarded.replace(guarded.find("\"to\""), 0, R"("until": {"input": "button"}, )");
  double off = 0.0;
  const program::Program program = good(tree(guarded));
  ASSERT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  off = std::max(off, off_line(tool_in_room(), from, from + kWay));
                  cell.button->sample.value = cycle >= 600;
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(off, 1e-9);
  ASSERT_TRUE(variables.touches.contains("arm"));
  const Eigen::Vector3d touch = variables.touches.at("arm").p_W;
  EXPECT_LT(off_line(touch, from, from + kWay), 1e-4) << "in the world, although the base went on";
  EXPECT_LT((touch - from).norm(), (tool_in_room() - from).norm());
  EXPECT_LT((tool_in_room() - from).norm(), 0.95 * kWay.norm());
  cell.button->sample.value = false;
  expect_both_free();
}

TEST_F(CarriedCommandTest, WhatMustNotHoldStopsBothOnTheLine) {
  const Eigen::Vector3d from = tool_in_room();
  double off = 0.0;
  const program::Program program = good(R"({"do": "lin", "arm": "arm", "to": {"in": "world", "by_m": [0.5, 0.3, 0.1]},
      "base_to": {"by_m": [0.4, 0.5, 0], "by_rpy_deg": [0, 0, 20]}, "abort_if": {"input": "button"}})");
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  off = std::max(off, off_line(tool_in_room(), from, from + kWay));
                  cell.button->sample.value = cycle >= 600;
                }),
            Progress::kFailed);
  ASSERT_EQ(diagnostics.list().size(), 1U) << diagnostics.to_string();
  EXPECT_EQ(diagnostics.list().front().code, Code::kAbortCondition);
  EXPECT_EQ(diagnostics.list().front().pointer, "/program/abort_if");
  EXPECT_LT(off, 1e-9);
  cell.button->sample.value = false;
  expect_both_free();
}

TEST_F(CarriedCommandTest, AFileMakesTheArmOnABaseCompliant) {
  const program::Program program = good(R"({"do": "sequence", "steps": [
      {"do": "control_mode", "arm": "arm", "mode": "cartesian_impedance"},
      {"do": "lin", "arm": "arm", "to": {"in": "world", "by_m": [0.1, 0, 0]}, "base_to": {"by_m": [0.1, 0, 0]},
       "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": 600}}]})");
  std::vector<RehearsedNet> nets;
  (void)program.rehearse(cell.cell, &cell.core.environment(), &nets);
  ASSERT_EQ(nets.size(), 1U);
  std::map<std::string, std::string> drivers;
  for (const auto& primitive : nets.front().net.fragments.at(0).net.primitives)
    if (primitive.type.ends_with("Command")) drivers[primitive.type] = primitive.parameters.at("device");
  EXPECT_EQ(drivers,
            (std::map<std::string, std::string>{{"ArmCommand", "base"}, {"CartesianImpedanceCommand", "arm"}}));
}

TEST_F(CarriedCommandTest, WhatAMotionWithABaseCannotHaveIsRefused) {
  const Diagnostics found = wrong(R"({"do": "lin", "arm": "arm", "to": {"by_m": [0.1, 0, 0]},
      "base_to": {"by_m": [0.1, 0, 0]}, "blend_m": 0.02, "weave": {"amplitude_m": 0.01, "frequency_Hz": 1}})");
  std::vector<std::string> places;
  for (const Diagnostic& one : found.list()) places.push_back(one.pointer);
  EXPECT_THAT(places, testing::IsSupersetOf({"/program/blend_m", "/program/weave"}));
}

// The base stays stiff: it has no springs.
TEST_F(CarriedCommandTest, OnlyTheArmOnABaseIsCompliant) {
  Eigen::Isometry3d X_goal = in_room();
  X_goal.translation() += Eigen::Vector3d(0.3, 0.1, 0.0);
  kinematics::JointVector q_goal = base().set_point().q;
  q_goal[0] += 0.3;
  const auto motion = command::carried_lin(cell.cell, "arm", {base().set_point().q, cell.q(), q_goal, X_goal});
  ASSERT_TRUE(motion) << motion.error().to_string();
  const auto compliant = [&](double stiffness) {
    const command::CartesianCompliance springs{.stiffness = net::Vector(stiffness, stiffness, stiffness)};
    const command::Action action = with_compliance(command::planned(*motion), springs);
    command::RuntimeCommand moved("straight", command::arm_on_base(cell.cell, "arm"), action);
    moved.on_entered(action.state("settled"), command::external("settled"));
    return moved;
  };
  const auto mapped = command::map(compliant(600.0));
  ASSERT_TRUE(mapped) << mapped.error().to_string();
  std::map<std::string, std::string> drivers;
  for (const auto& primitive : mapped->net.fragments.at(0).net.primitives)
    if (primitive.type.ends_with("Command")) drivers[primitive.type] = primitive.parameters.at("device");
  EXPECT_EQ(drivers,
            (std::map<std::string, std::string>{{"ArmCommand", "base"}, {"CartesianImpedanceCommand", "arm"}}));
  EXPECT_THAT(command::check(compliant(1e6)),
              testing::AllOf(Reports(Code::kOutOfRange, "/straight/compliance/stiffness/0", {"arm"}),
                             testing::Not(takt::test::ReportsAnywhere(Code::kOutOfRange, {"base"}))));
}

}  // namespace
}  // namespace takt::operations
