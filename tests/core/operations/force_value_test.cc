// Forces and torques as values of a program: what a condition looks at, and nothing else.
#include <nlohmann/json.hpp>

#include "core/program/language/expression.h"
#include "tests/core/activity/fixture.h"
#include "tests/core/activity/two_arm_cell.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

class ForceValueTest : public test::ActivityTest {
 protected:
  /// What the text is worth now.
  program::Value value(const std::string& text) {
    const program::Scope scope;
    const program::EvalContext eval_context{.mode = program::EvalContext::Mode::kRun,
                                            .scope = &scope,
                                            .cell = &fake.cell,
                                            .measured = &variables,
                                            .q = nullptr,
                                            .time = fake.core.time()};
    diagnostics = {};
    const auto expression = program::Expression::parse(text);
    return expression ? expression->evaluate(eval_context, diagnostics) : program::Value{};
  }
  static std::string let(const std::string& text) {
    return R"({"do": "sequence", "variables": {"f": {"unit": "N", "nominal": 7}}, "steps": [
      {"do": "let", "values": {"f": ")" +
           text + R"_("}}, {"do": "log", "text": "$text(f)"}]})_";
  }
};

TEST_F(ForceValueTest, WeightAndOffsetAreTakenOutInEveryPosture) {
  variables.biases["wrist"] = fake.bias;
  for (const char* goal : {"\"home\"", R"({"by_rpy_deg": [40, -30, 20]})", R"({"by_rpy_deg": [0, 60, 0]})"}) {
    ASSERT_EQ(run(std::string(R"({"do": "ptp", "to": )") + goal + "}"), Progress::kDone) << diagnostics.to_string();
    fake.extra = {.force = {1.0, -2.0, 2.0}, .torque = {0.0, 0.3, -0.4}};
    fake.step();
    EXPECT_NEAR(value("force('wrist')").number(), 3.0, 1e-9) << goal;
    EXPECT_NEAR(value("force_x('wrist')").number(), 1.0, 1e-9);
    EXPECT_NEAR(value("force_y('wrist')").number(), -2.0, 1e-9);
    EXPECT_NEAR(value("force_z('wrist')").number(), 2.0, 1e-9);
    EXPECT_NEAR(value("torque('wrist')").number(), 0.5, 1e-9);
    EXPECT_NEAR(value("torque_x('wrist')").number(), 0.0, 1e-9);
    EXPECT_NEAR(value("torque_y('wrist')").number(), 0.3, 1e-9);
    EXPECT_NEAR(value("torque_z('wrist')").number(), -0.4, 1e-9);
    fake.extra = {};
  }
}

TEST_F(ForceValueTest, WithoutATareTheOffsetIsStillInIt) {
  EXPECT_NEAR(value("force('wrist')").number(), fake.bias.force.norm(), 1e-9);
  ASSERT_EQ(run(R"({"do": "tare", "cycles": 20})"), Progress::kDone);
  EXPECT_LT(value("force('wrist')").number(), 1e-9);
}

TEST_F(ForceValueTest, N2_ASilentSensorIsUnknownAndComesBack) {
  variables.biases["wrist"] = fake.bias;
  fake.sensor->silent = true;
  fake.step(10);
  EXPECT_TRUE(value("force('wrist')").null());
  EXPECT_TRUE(value("torque_z('wrist')").null());
  EXPECT_TRUE(value("force('wrist') > 5[N]").null());
  EXPECT_FALSE(value("known(force('wrist'))").boolean());
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  fake.sensor->silent = false;
  fake.step();
  EXPECT_LT(value("force('wrist')").number(), 1e-9);
}

TEST_F(ForceValueTest, UnitsAndNamesAreChecked) {
  EXPECT_EQ(program::to_string(value("force('wrist') / force('wrist')").type), "number without a unit");
  (void)value("force('wrist') + 1[Nm]");
  EXPECT_THAT(diagnostics, Reports(Code::kTypeMismatch, "", {"+"}));
  EXPECT_THAT(parse(let("$torque('wrist')")).error(), Reports(Code::kWrongType, "/program/steps/0/values/f"));
  EXPECT_THAT(parse(let("$force('writs')")).error(),
              Reports(Code::kTypeMismatch, "/program/steps/0/values/f", {"writs", "wrist"}));
}

TEST_F(ForceValueTest, AProgramDecidesByAForceAndIsRehearsedOnItsNominalValue) {
  variables.biases["wrist"] = fake.bias;
  const program::Program program = good(let("$force('wrist')"));
  EXPECT_FALSE(program.rehearse(fake.cell).diagnostics.has_errors());
  fake.extra.force = {0.0, 3.0, 4.0};
  fake.step();
  ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
  EXPECT_EQ(log.back(), "program: log 5 N");
  // It waits until somebody pushes: asked between all cycles.
  fake.extra = {};
  EXPECT_EQ(run(good(R"({"do": "wait", "until": "$force_z('wrist') > 9[N]", "timeout_s": 1})"),
                [this](int cycle, program::ProgramRunner&) { fake.extra.force.z() = cycle >= 100 ? 10.0 : 0.0; }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_NEAR(cycles, 101, 1);
}

// A motion to where the force says: the expression is answered when its step begins.
TEST_F(ForceValueTest, AStepTakesAForceAsItsFigure) {
  variables.biases["wrist"] = fake.bias;
  fake.extra.force = {0.0, 0.0, 10.0};
  fake.step();
  const Eigen::Vector3d before = fake.tool_in_world(fake.q()).translation();
  ASSERT_EQ(run(R"_({"do": "lin", "to": {"by_m": [0, 0, "$0.005[m/N] * force('wrist')"]}})_"), Progress::kDone)
      << diagnostics.to_string();
  EXPECT_NEAR((fake.tool_in_world(fake.q()).translation() - before).z(), 0.05, 1e-6);
}

/// Two arms that look at each other: what one pushes and the other pushes back counts, what both push does not.
TEST(InternalForceValue, IsHalfTheDifferenceInTheWorld) {
  test::TwoArmCell two;
  activity::Variables variables;
  const auto value = [&](const std::string& text, Diagnostics& diagnostics) {
    const program::Scope scope;
    const program::EvalContext eval_context{.mode = program::EvalContext::Mode::kRun,
                                            .scope = &scope,
                                            .cell = &two.cell,
                                            .measured = &variables,
                                            .q = nullptr,
                                            .time = two.core.time()};
    return program::Expression::parse(text)->evaluate(eval_context, diagnostics);
  };
  const auto push = [&](double left_N, double right_N) {
    for (const auto& [name, force] : {std::pair("left", left_N), std::pair("right", right_N)}) {
      const app::Actuator one(two.program, name);
      const Eigen::Matrix3d R_WF = (one.frame("world").inverse() * one.flange()).linear();
      two.wrists[name]->sample.wrench.force = R_WF.transpose() * (force * Eigen::Vector3d::UnitX());
    }
    two.core.step();
  };
  Diagnostics diagnostics;
  push(30.0, -10.0);
  EXPECT_NEAR(value("internal_force('left wrist', 'right wrist')", diagnostics).number(), 20.0, 1e-9);
  push(30.0, 30.0);
  EXPECT_NEAR(value("internal_force('right wrist', 'left wrist')", diagnostics).number(), 0.0, 1e-9);
  EXPECT_EQ(program::to_string(value("internal_force('left wrist', 'right wrist')", diagnostics).type), "number in N");
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  two.wrists["right"]->silent = true;
  for (int i = 0; i < 10; ++i) two.core.step();
  EXPECT_TRUE(value("internal_force('left wrist', 'right wrist')", diagnostics).null());
  (void)value("internal_force('left wrist', 'right wirst')", diagnostics);
  EXPECT_THAT(diagnostics, Reports(Code::kTypeMismatch, "", {"right wirst", "right wrist"}));
}

}  // namespace
}  // namespace takt::operations
