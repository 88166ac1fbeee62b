// Functions of one and two numbers, conversions, thresholds: rows of arguments and results, edges of the range
// included.
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::Integer;
using net::Real;
using Json = nlohmann::ordered_json;
using MaybeReal = std::optional<double>;
using MaybeInteger = std::optional<Integer>;
constexpr double kPi = std::numbers::pi;
constexpr Integer kMost = std::numeric_limits<Integer>::max(), kLeast = std::numeric_limits<Integer>::min();

MaybeReal of(const char* type, double x, const Json& parameters = Json::object()) {
  return PrimitiveHarness(type, parameters).set("input", x).step().get<Real>("value");
}

TEST(Arithmetic, FunctionsOfOneNumber) {
  EXPECT_EQ(of("Sign", -3.0), -1.0);
  EXPECT_EQ(of("Sign", 0.0), 0.0);
  EXPECT_EQ(of("Square", -3.0), 9.0);
  EXPECT_EQ(of("SquareRoot", 9.0), 3.0);
  EXPECT_EQ(of("SquareRoot", -1e-300), std::nullopt);
  EXPECT_EQ(of("Affine", 3.0, {{"factor", 2.0}, {"offset", -1.0}}), 5.0);
  EXPECT_EQ(of("Power", 3.0, {{"exponent", 3.0}}), 27.0);
  EXPECT_EQ(of("Power", -8.0, {{"exponent", 0.5}}), std::nullopt);
  EXPECT_EQ(of("Exponential", 0.0), 1.0);
  EXPECT_NEAR(*of("Logarithm", std::exp(2.0)), 2.0, 1e-15);
  EXPECT_EQ(of("Logarithm", 0.0), std::nullopt);
  EXPECT_NEAR(*of("Sine", kPi / 6), 0.5, 1e-15);
  EXPECT_NEAR(*of("Cosine", kPi / 3), 0.5, 1e-15);
  EXPECT_NEAR(*of("Tangent", kPi / 4), 1.0, 1e-15);
  EXPECT_NEAR(*of("ArcSine", 0.5), kPi / 6, 1e-15);
  EXPECT_NEAR(*of("ArcCosine", 0.5), kPi / 3, 1e-15);
  EXPECT_EQ(of("ArcSine", 1.0000001), std::nullopt);
  EXPECT_EQ(of("ArcCosine", -1.0000001), std::nullopt);
  EXPECT_EQ(of("RadiansToRatio", 0.25), 0.25);
  EXPECT_EQ(of("RatioToRadians", 0.25), 0.25);
}

TEST(Arithmetic, AnglesWrapIntoOneTurn) {
  for (const auto& [x, wrapped] :
       {std::pair{kPi, kPi}, {-kPi, kPi}, {3.0 * kPi / 2.0, -kPi / 2.0}, {0.5, 0.5}, {100.0 * kPi + 0.5, 0.5}})
    EXPECT_NEAR(*of("WrapAngle", x), wrapped, 1e-12) << x;
  EXPECT_EQ(PrimitiveHarness("ArcTangent2").set("y", -1.0).set("x", -1.0).step().get<Real>("value"), -0.75 * kPi);
}

TEST(Arithmetic, ModuloHasTheSignOfTheDivisor) {
  const auto modulo = [](double a, double b) {
    return PrimitiveHarness("Modulo").set("a", a).set("b", b).step().get<Real>("value");
  };
  EXPECT_EQ(modulo(7, 3), 1.0);
  EXPECT_EQ(modulo(-7, 3), 2.0);
  EXPECT_EQ(modulo(7, -3), -2.0);
  EXPECT_EQ(modulo(6, 3), 0.0);
  EXPECT_EQ(modulo(6, 0), std::nullopt);
  PrimitiveHarness line("Interpolate");
  line.set("a", 0.1).set("b", 0.7);
  EXPECT_EQ(line.set("share", 1.0).step().get<Real>("value"), 0.7);
  EXPECT_DOUBLE_EQ(*line.set("share", 0.5).step().get<Real>("value"), 0.4);
}

TEST(Arithmetic, WholeNumbersDoNotOverflowInSilence) {
  struct Row {
    const char* type;
    Integer a, b;
    MaybeInteger value;
  };
  for (const Row& row :
       {Row{"AddIntegers", 2, 3, 5}, Row{"AddIntegers", kMost, 1, {}}, Row{"SubtractIntegers", 2, 3, -1},
        Row{"SubtractIntegers", kLeast, 1, {}}, Row{"MultiplyIntegers", -4, 3, -12},
        Row{"MultiplyIntegers", kMost, 2, {}}, Row{"DivideIntegers", -7, 2, -3}, Row{"DivideIntegers", 7, 0, {}},
        Row{"DivideIntegers", kLeast, -1, {}}, Row{"ModuloIntegers", -7, 3, 2}, Row{"ModuloIntegers", 7, -3, -2},
        Row{"ModuloIntegers", 7, 0, {}}, Row{"ModuloIntegers", kLeast, -1, 0}}) {
    PrimitiveHarness primitive(row.type);
    primitive.set<Integer>("a", row.a).set<Integer>("b", row.b).step();
    EXPECT_EQ(primitive.get<Integer>("value"), row.value) << row.type << " " << row.a << " " << row.b;
  }
}

TEST(Arithmetic, RoundingAndBack) {
  struct Row {
    double x;
    MaybeInteger floor, ceiling, round;
  };
  for (const Row& row : {Row{2.5, 2, 3, 3}, Row{-2.5, -3, -2, -3}, Row{2.0, 2, 2, 2}, Row{1e300, {}, {}, {}},
                         Row{-9223372036854775808.0, kLeast, kLeast, kLeast}, Row{9223372036854775808.0, {}, {}, {}}}) {
    const auto whole = [&row](const char* type) {
      return PrimitiveHarness(type).set("input", row.x).step().get<Integer>("value");
    };
    EXPECT_EQ(whole("Floor"), row.floor) << row.x;
    EXPECT_EQ(whole("Ceiling"), row.ceiling) << row.x;
    EXPECT_EQ(whole("Round"), row.round) << row.x;
  }
  EXPECT_EQ(PrimitiveHarness("IntegerToReal").set<Integer>("input", -7).step().get<Real>("value"), -7.0);
  EXPECT_EQ(PrimitiveHarness("BooleanToInteger").set("input", true).step().get<Integer>("value"), 1);
}

TEST(Comparison, OfWholeNumbersAndTexts) {
  const auto ask = [](const char* type, Integer a, Integer b) {
    return PrimitiveHarness(type).set<Integer>("a", a).set<Integer>("b", b).step().get<Boolean>("value");
  };
  EXPECT_EQ(ask("GreaterThanInteger", kMost, kMost - 1), true);  // beyond what a double can tell apart
  EXPECT_EQ(ask("LessThanInteger", kMost - 1, kMost), true);
  EXPECT_EQ(ask("EqualIntegers", kMost - 1, kMost), false);
  EXPECT_EQ(ask("EqualIntegers", 4, 4), true);
  PrimitiveHarness texts("EqualStrings");
  EXPECT_EQ(texts.set("a", net::Text("ab")).set("b", net::Text("ab")).step().get<Boolean>("value"), true);
  EXPECT_EQ(texts.set("b", net::Text("abc")).step().get<Boolean>("value"), false);
  const auto compare = [](const char* type, double a, double b) {
    return PrimitiveHarness(type).set("a", a).set("b", b).step().get<Boolean>("value");
  };
  EXPECT_EQ(compare("AtLeast", 1, 1), true);
  EXPECT_EQ(compare("AtLeast", 0.9, 1), false);
  EXPECT_EQ(compare("AtMost", 1, 1), true);
  EXPECT_EQ(compare("AtMost", 1.1, 1), false);
}

/// Row N2: null wherever the rest does not decide.
TEST(Logic, N2_ImplicationAndMajority) {
  using Truth = std::optional<bool>;
  constexpr Truth kTrue = true, kFalse = false, kNull;
  struct Row {
    const char* type;
    Truth a, b, c, result;
  };
  for (const Row& row : {Row{"Implies", kTrue, kFalse, kNull, kFalse}, Row{"Implies", kFalse, kNull, kNull, kTrue},
                         Row{"Implies", kNull, kTrue, kNull, kTrue}, Row{"Implies", kTrue, kNull, kNull, kNull},
                         Row{"Implies", kNull, kFalse, kNull, kNull}, Row{"Implies", kTrue, kTrue, kNull, kTrue},
                         Row{"Majority", kTrue, kNull, kTrue, kTrue}, Row{"Majority", kFalse, kFalse, kNull, kFalse},
                         Row{"Majority", kTrue, kFalse, kNull, kNull}, Row{"Majority", kTrue, kFalse, kTrue, kTrue},
                         Row{"Majority", kNull, kNull, kTrue, kNull}}) {
    PrimitiveHarness primitive(row.type);
    if (row.a) primitive.set("a", *row.a);
    if (row.b) primitive.set("b", *row.b);
    if (row.c) primitive.set("c", *row.c);
    EXPECT_EQ(primitive.step().get<Boolean>("value"), row.result) << row.type;
  }
  EXPECT_EQ(PrimitiveHarness("Equivalent").set("a", false).set("b", false).step().get<Boolean>("value"), true);
}

TEST(Limit, BandsAndThresholds) {
  EXPECT_DOUBLE_EQ(*of("DeadBand", 0.5, {{"width", 0.2}}), 0.3);
  EXPECT_DOUBLE_EQ(*of("DeadBand", -0.5, {{"width", 0.2}}), -0.3);
  EXPECT_EQ(of("DeadBand", -0.1, {{"width", 0.2}}), 0.0);
  EXPECT_EQ(of("Quantize", 0.38, {{"step", 0.25}}), 0.5);
  EXPECT_EQ(of("Quantize", -0.37, {{"step", 0.25}}), -0.25);
  PrimitiveHarness clamp("Clamp");
  clamp.set("lower", -1.0).set("upper", 2.0);
  EXPECT_EQ(clamp.set("input", 5.0).step().get<Real>("value"), 2.0);
  EXPECT_EQ(clamp.get<Boolean>("limited"), true);
  EXPECT_TRUE(clamp.set("upper", -2.0).step().is_null("value"));
  PrimitiveHarness trigger("Hysteresis", {{"lower", -1.0}, {"upper", 1.0}});
  const std::pair<double, bool> rows[] = {{0.0, false}, {1.0, false},  {1.1, true}, {0.0, true},
                                          {-1.0, true}, {-1.1, false}, {0.9, false}};
  for (const auto& [x, value] : rows) EXPECT_EQ(trigger.set("input", x).step().get<Boolean>("value"), value) << x;
  trigger.set("input", 2.0).step().set_null("input").step();
  EXPECT_EQ(trigger.set("input", 0.0).step().get<Boolean>("value"), false);  // null forgets
}

}  // namespace
}  // namespace takt::test
