// The language of expressions: arithmetic with units, three-valued logic, functions, and all that can be wrong.
#include "core/program/language/expression.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/operations/table/step.h"
#include "tests/support/reports.h"

namespace takt::program {
namespace {

using takt::test::Reports;
using testing::AllOf;

class ExpressionTest : public testing::Test {
 protected:
  ExpressionTest() {
    scope.declare("n", {Type::number(), Value::of(3.0), {}});
    scope.declare("h", {Type::number(unit_dimension("m")), Value::of(0.25, unit_dimension("m")), {}});
    scope.declare("gone", {Type::number(unit_dimension("m")), Value::unknown(Type::number(unit_dimension("m"))), {}});
    scope.declare("open", {Type::boolean(), Value::unknown(Type::boolean()), {}});
    scope.declare("who", {Type::text(), Value::of(std::string("red")), {}});
    scope.declare("list", {Type::list_of(Type::number()), Value::of({Value::of(4.0), Value::of(1.0)}), {}});
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() << 1, 2, 3;
    scope.declare("p", {Type::pose(), Value::of(X), {}});
  }

  EvalContext eval_context(EvalContext::Mode mode = EvalContext::Mode::kRun) const {
    return {.mode = mode, .scope = &scope, .cell = &cell, .measured = &measured, .q = nullptr, .time = 2 * kSecond};
  }
  Value value(const std::string& text, EvalContext::Mode mode = EvalContext::Mode::kRun) {
    const auto expression = Expression::parse(text);
    if (!expression) {
      errors = expression.error();
      return {};
    }
    Diagnostics diagnostics;
    const Value result = expression->evaluate(eval_context(mode), diagnostics);
    errors = diagnostics;
    return result;
  }
  /// As people see it; empty if something was wrong.
  std::string shown(const std::string& text) {
    const Value result = value(text);
    return errors.empty() ? to_string(result) : "";
  }
  Diagnostics wrong(const std::string& text) {
    (void)value(text);
    return errors;
  }

  Scope scope;
  expression::Cell cell;
  activity::Variables measured;
  Diagnostics errors;
};

TEST_F(ExpressionTest, ArithmeticBindsAsInMathematics) {
  EXPECT_EQ(shown("1 + 2 * 3 - 4 / 2"), "5");
  EXPECT_EQ(shown("(1 + 2) * 3"), "9");
  EXPECT_EQ(shown("-n - -2"), "-1");
  EXPECT_EQ(shown("7 % 4 + (-1) % 4"), "6");
  EXPECT_EQ(shown("10 - 4 - 3"), "3");
  EXPECT_EQ(shown("1e2 + .5"), "100.5");
}

TEST_F(ExpressionTest, UnitsAreCarriedAndCompared) {
  EXPECT_EQ(shown("h + 50[mm]"), "0.3 m");
  EXPECT_EQ(shown("h * 2[m]"), "0.5 m^2");
  EXPECT_EQ(shown("0.5[m] / 2[s]"), "0.25 m/s");
  EXPECT_EQ(shown("sqrt(h * h)"), "0.25 m");
  EXPECT_EQ(shown("magnitude(h)"), "0.25");
  EXPECT_NEAR(value("90[deg]").number(), 0.5 * std::numbers::pi, 1e-15);
  EXPECT_EQ(shown("5[N] > 4[N] and 2[kg] >= 2000[g]"), "true");
  EXPECT_THAT(wrong("h + 1"), Reports(Code::kTypeMismatch, "", {"+", "3", "0.1"}));
  EXPECT_THAT(wrong("h < 3[N]"), Reports(Code::kTypeMismatch, "", {"<"}));
  EXPECT_THAT(wrong("3[furlong]"), Reports(Code::kSyntax, "", {"furlong"}));
  EXPECT_THAT(wrong("sin(h)"), Reports(Code::kTypeMismatch, "", {"sin", "90"}));
}

TEST_F(ExpressionTest, N2_LogicHasThreeValues) {
  EXPECT_EQ(shown("open or true"), "true");
  EXPECT_EQ(shown("false and open"), "false");
  EXPECT_EQ(shown("open and true"), "unknown");
  EXPECT_EQ(shown("not open"), "unknown");
  EXPECT_EQ(shown("gone < 1[m]"), "unknown");
  EXPECT_EQ(shown("gone < 1[m] or n == 3"), "true");
  EXPECT_EQ(shown("known(gone) or known(h)"), "true");
  EXPECT_EQ(shown("select(n > 2, 'many', 'few')"), "many");
}

TEST_F(ExpressionTest, TextsListsAndPoses) {
  EXPECT_EQ(shown("'part ' + text(n) + ' is ' + who"), "part 3 is red");
  EXPECT_EQ(shown("who == 'red'"), "true");
  EXPECT_EQ(shown("list[0] + list[n - 2]"), "5");
  EXPECT_EQ(shown("length(append(list, 7))"), "3");
  EXPECT_EQ(shown("sum([1, 2, 3]) + mean(list) + least(list) + greatest(list)"), "13.5");
  EXPECT_EQ(shown("x(p * at(0.5[m], 0[m], 0[m]))"), "1.5 m");
  EXPECT_EQ(shown("y(p * rpy(0[rad], 0[rad], 90[deg]) * at(1[m], 0[m], 0[m]))"), "3 m");
  EXPECT_EQ(shown("distance(p, p * at(3[mm], 4[mm], 0[m]))"), "0.005 m");
  EXPECT_EQ(shown("yaw(rpy(0[rad], 0[rad], 1[rad]))"), "1 rad");
  EXPECT_EQ(shown("time()"), "2 s");
  EXPECT_EQ(shown("p == p and [1, 2] == [1, 2] and [1, 2] != [1, 3]"), "true");
}

TEST_F(ExpressionTest, WhatIsMeasuredCanBeAskedFor) {
  measured.residuals["found"] = 0.001;
  measured.monitors["net"]["count"] = "5";
  measured.monitors["net"]["seen"] = "true";
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << 0.5, 0, 0;
  ASSERT_TRUE(cell.frames.add("tray", "world", X).empty());
  cell.arms["arm"] = {};
  measured.touches["arm"] = {.p_W = {1, 2, 3}, .radius = 0.01, .cycle = 7};
  EXPECT_EQ(shown("residual('found') < 2[mm]"), "true");
  EXPECT_EQ(shown("monitor('net', 'count') + 1"), "6");
  EXPECT_EQ(shown("monitor('net', 'seen')"), "true");
  EXPECT_EQ(shown("monitor('net', 'other')"), "unknown");
  EXPECT_EQ(shown("x(pose('tray'))"), "0.5 m");
  EXPECT_EQ(shown("z(touch('arm'))"), "3 m");
  EXPECT_THAT(wrong("pose('tary')"), Reports(Code::kTypeMismatch, "", {"tary"}));
  EXPECT_THAT(wrong("touch('amr')"), Reports(Code::kTypeMismatch, "", {"amr"}));
  EXPECT_THAT(wrong("input('button')"), Reports(Code::kTypeMismatch, "", {"button"}));
  EXPECT_THAT(wrong("width('gripper')"), Reports(Code::kTypeMismatch, "", {"gripper"}));
}

TEST_F(ExpressionTest, TypesAreCheckedWithNothingKnown) {
  EXPECT_EQ(value("h + 1[m]", EvalContext::Mode::kCheck).type, Type::number(unit_dimension("m")));
  EXPECT_TRUE(value("n", EvalContext::Mode::kCheck).null());
  EXPECT_EQ(value("list[5] * 2", EvalContext::Mode::kCheck).type, Type::number());
  EXPECT_EQ(value("pose('nowhere')", EvalContext::Mode::kCheck).type, Type::pose());
  EXPECT_EQ(errors.to_string(), "") << "the frame may be made before";
  (void)value("n / 0", EvalContext::Mode::kCheck);
  EXPECT_EQ(errors.to_string(), "");
}

TEST_F(ExpressionTest, AllThatIsWrongIsToldAtOnceWithItsPlace) {
  (void)value("nn + sqtr(2) + (who < 3)");
  EXPECT_THAT(errors,
              AllOf(Reports(Code::kUnknownName, "", {"nn", "1"}), Reports(Code::kUnknownName, "", {"sqtr", "6"}),
                    Reports(Code::kUnknownName, "", {"sqrt"}), Reports(Code::kTypeMismatch, "", {"<", "21"})));
}

TEST_F(ExpressionTest, WhatCannotBeReadIsRefused) {
  EXPECT_THAT(wrong(""), Reports(Code::kSyntax, ""));
  EXPECT_THAT(wrong("1 +"), Reports(Code::kSyntax, ""));
  EXPECT_THAT(wrong("(1"), Reports(Code::kSyntax, "", {")"}));
  EXPECT_THAT(wrong("1 2"), Reports(Code::kSyntax, "", {"2"}));
  EXPECT_THAT(wrong("'open"), Reports(Code::kSyntax, ""));
  EXPECT_THAT(wrong("1[m"), Reports(Code::kSyntax, ""));
  EXPECT_THAT(wrong("#"), Reports(Code::kSyntax, "", {"#"}));
  EXPECT_THAT(wrong("1e999"), Reports(Code::kSyntax, ""));
  EXPECT_THAT(wrong(std::string(60, '(') + "1" + std::string(60, ')')), Reports(Code::kSyntax, ""));
  EXPECT_THAT(wrong(std::string(2000, '1')), Reports(Code::kTooLarge, "", {"1000"}));
  EXPECT_THAT(wrong(std::string(500, '-') + "1"), Reports(Code::kSyntax, ""));
}

TEST_F(ExpressionTest, WhatGrowsInALoopIsBounded) {
  const std::string half(40'000, 'x');
  scope.declare("long", {Type::text(), Value::of(half), {}});
  EXPECT_THAT(wrong("long + long"), Reports(Code::kTooLarge, "", {"80000", "65536"}));
  EXPECT_EQ(value("long + who").text().size(), half.size() + 3);
  std::vector<Value> texts(100, Value::of(half));
  scope.declare("texts", {Type::list_of(Type::text()), Value::of(texts), {}});
  EXPECT_EQ(value("append(texts, long)").list().size(), 101u);
  EXPECT_THAT(wrong("text(texts)"), Reports(Code::kTypeMismatch, "", {"4000200", "65536"}));
  texts.resize(110, Value::of(half));
  scope.declare("texts", {Type::list_of(Type::text()), Value::of(texts), {}});
  EXPECT_THAT(wrong("append(texts, long)"), Reports(Code::kTypeMismatch, "", {"4194304"}));
}

TEST_F(ExpressionTest, WhatHasNoValueIsAnErrorInTheRun) {
  EXPECT_THAT(wrong("1 / 0"), Reports(Code::kTypeMismatch, "", {"1", "0"}));
  EXPECT_THAT(wrong("sqrt(-1)"), Reports(Code::kTypeMismatch, ""));
  EXPECT_THAT(wrong("list[2]"), Reports(Code::kOutOfRange, "", {"2"}));
  EXPECT_THAT(wrong("list[0.5]"), Reports(Code::kOutOfRange, "", {"0.5"}));
  EXPECT_THAT(wrong("mean([])"), Reports(Code::kTypeMismatch, ""));
  EXPECT_THAT(wrong("max(1, 2, 3)"), Reports(Code::kTypeMismatch, "", {"max", "2", "3"}));
  EXPECT_THAT(wrong("[1, 'a']"), Reports(Code::kTypeMismatch, ""));
  EXPECT_THAT(wrong("append(list, 'a')"), Reports(Code::kTypeMismatch, ""));
  EXPECT_THAT(wrong("select(true, 1, 'a')"), Reports(Code::kTypeMismatch, ""));
  EXPECT_THAT(wrong("n[0]"), Reports(Code::kTypeMismatch, ""));
  EXPECT_THAT(wrong("-who"), Reports(Code::kTypeMismatch, ""));
}

TEST_F(ExpressionTest, D3_ValuesAreDataAndComeBack) {
  for (const char* text : {"h", "n", "who", "list", "p", "gone", "[p, p]", "true", "[]"}) {
    const Value before = value(text);
    const Value after = value_from_json(to_json(before));
    EXPECT_EQ(after.type, before.type) << text;
    EXPECT_EQ(to_string(after), to_string(before)) << text;
  }
}

TEST(Functions, AreSortedAndSayWhatTheyDo) {
  for (std::size_t i = 0; i < functions().size(); ++i) {
    EXPECT_TRUE(i == 0 || functions()[i - 1].name < functions()[i].name) << functions()[i].name;
    EXPECT_TRUE(functions()[i].doc.starts_with(functions()[i].name)) << functions()[i].name;
  }
}

}  // namespace
}  // namespace takt::program
