// Family "arithmetic": real numbers with units, whole numbers, and the ways between them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/net/registry.h"
#include "core/primitives/function.h"

namespace takt::primitives::numbers {
namespace {

using net::Boolean;
using net::Integer;

// -- Real numbers -----------------------------------------------------------------------------------------------------

constexpr auto kAlike = [] {
  return ports({{"a", "u", "left side"}, {"b", "u", "right side"}}, {{"value", "u", "the result"}});
};
constexpr auto kProduct = [] {
  return ports({{"a", "u", "left side"}, {"b", "v", "right side"}}, {{"value", "u*v", "the product"}});
};
constexpr auto kQuotient = [] {
  return ports({{"a", "u", "left side"}, {"b", "v", "right side"}}, {{"value", "u/v", "the quotient"}});
};
constexpr auto kSameUnit = [] { return ports({{"input", "u", "the argument"}}, {{"value", "u", "the result"}}); };
constexpr auto kPlain = [] { return ports({{"input", "1", "the argument"}}, {{"value", "1", "the result"}}); };
constexpr auto kSign = [] { return ports({{"input", "u", "the argument"}}, {{"value", "1", "-1, 0 or 1"}}); };
constexpr auto kSquare = [] { return ports({{"input", "u", "the argument"}}, {{"value", "u^2", "its square"}}); };
constexpr auto kRoot = [] { return ports({{"input", "u", "the argument"}}, {{"value", "u^1/2", "its root, >= 0"}}); };
constexpr auto kGain = [] {
  return ports({{"input", "u", "the argument"}}, {{"value", "u", "the result"}},
               {{"factor", "1", "what the input is multiplied by", "", "2.0"}});
};
constexpr auto kAffine = [] {
  return ports({{"input", "u", "the argument"}}, {{"value", "v", "factor * input + offset"}},
               {{"factor", "v/u", "slope", "", "2.0"}, {"offset", "v", "value where the input is 0", "", "0.5"}});
};
constexpr auto kPower = [] {
  return ports({{"input", "1", "the argument"}}, {{"value", "1", "input ^ exponent"}},
               {{"exponent", "1", "the exponent", "", "2.0"}});
};
constexpr auto kInterpolate = [] {
  return ports(
      {{"a", "u", "given where share is 0"}, {"b", "u", "given where share is 1"}, {"share", "1", "any number"}},
      {{"value", "u", "a + share (b - a)"}});
};

using Add = Function<kAlike, [](double a, double b) { return a + b; }>;
using Subtract = Function<kAlike, [](double a, double b) { return a - b; }>;
using Multiply = Function<kProduct, [](double a, double b) { return a * b; }>;
using Divide = Function<kQuotient, [](double a, double b) { return b == 0.0 ? std::nullopt : std::optional(a / b); }>;
using Modulo = Function<kAlike, [](double a, double b) -> std::optional<double> {
  if (b == 0.0) return std::nullopt;
  const double remainder = std::fmod(a, b);
  return remainder != 0.0 && (remainder < 0.0) != (b < 0.0) ? remainder + b : remainder;
}>;
using Min = Function<kAlike, [](double a, double b) { return std::min(a, b); }>;
using Max = Function<kAlike, [](double a, double b) { return std::max(a, b); }>;
using Negate = Function<kSameUnit, [](double x) { return -x; }>;
using Abs = Function<kSameUnit, [](double x) { return std::abs(x); }>;
using Sign = Function<kSign, [](double x) { return static_cast<double>((x > 0.0) - (x < 0.0)); }>;
using Square = Function<kSquare, [](double x) { return x * x; }>;
using SquareRoot = Function<kRoot, [](double x) { return x < 0.0 ? std::nullopt : std::optional(std::sqrt(x)); }>;
using Gain = Function<kGain, [](double x, double factor) { return factor * x; }>;
using Affine = Function<kAffine, [](double x, double factor, double offset) { return factor * x + offset; }>;
using Power = Function<kPower, [](double x, double exponent) {
  const double value = std::pow(x, exponent);
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}>;
using Exponential = Function<kPlain, [](double x) { return std::exp(x); }>;
using Logarithm = Function<kPlain, [](double x) { return x <= 0.0 ? std::nullopt : std::optional(std::log(x)); }>;
using Interpolate =
    Function<kInterpolate, [](double a, double b, double share) { return share == 1.0 ? b : a + share * (b - a); }>;

TAKT_PRIMITIVE(Add, "arithmetic", "a + b.");
TAKT_PRIMITIVE(Subtract, "arithmetic", "a - b.");
TAKT_PRIMITIVE(Multiply, "arithmetic", "a * b; the units multiply.");
TAKT_PRIMITIVE(Divide, "arithmetic", "a / b; the units divide. Null if b is zero.");
TAKT_PRIMITIVE(Modulo, "arithmetic",
               "What is left of a after whole multiples of b, with the sign of b. Null if b is 0.");
TAKT_PRIMITIVE(Min, "arithmetic", "The smaller of a and b.");
TAKT_PRIMITIVE(Max, "arithmetic", "The larger of a and b.");
TAKT_PRIMITIVE(Negate, "arithmetic", "-input.");
TAKT_PRIMITIVE(Abs, "arithmetic", "|input|.");
TAKT_PRIMITIVE(Sign, "arithmetic", "1 for a positive input, -1 for a negative one, else 0.");
TAKT_PRIMITIVE(Square, "arithmetic", "input * input.");
TAKT_PRIMITIVE(SquareRoot, "arithmetic", "The root of the input. Null of a negative number.");
TAKT_PRIMITIVE(Gain, "arithmetic", "factor * input; the unit stays.");
TAKT_PRIMITIVE(Affine, "arithmetic",
               "factor * input + offset, such as the calibration of a sensor; a unit of its own.");
TAKT_PRIMITIVE(Power, "arithmetic", "input ^ exponent. Null where that is not a real number.");
TAKT_PRIMITIVE(Exponential, "arithmetic", "e ^ input.");
TAKT_PRIMITIVE(Logarithm, "arithmetic", "The natural logarithm. Null unless the input is positive.");
TAKT_PRIMITIVE(Interpolate, "arithmetic", "On the line through a and b: a at share 0, b at share 1; also beyond.");

// -- Angles -----------------------------------------------------------------------------------------------------------

constexpr auto kOfAngle = [] { return ports({{"input", "rad", "an angle"}}, {{"value", "1", "the result"}}); };
constexpr auto kToAngle = [] { return ports({{"input", "1", "the argument"}}, {{"value", "rad", "an angle"}}); };
constexpr auto kAngle = [] { return ports({{"input", "rad", "an angle"}}, {{"value", "rad", "an angle"}}); };
constexpr auto kTwoSides = [] {
  return ports({{"y", "u", "side across"}, {"x", "u", "side along"}}, {{"value", "rad", "angle in (-pi, pi]"}});
};

using Sine = Function<kOfAngle, [](double x) { return std::sin(x); }>;
using Cosine = Function<kOfAngle, [](double x) { return std::cos(x); }>;
using Tangent = Function<kOfAngle, [](double x) { return std::tan(x); }>;
using ArcSine =
    Function<kToAngle, [](double x) { return std::abs(x) <= 1.0 ? std::optional(std::asin(x)) : std::nullopt; }>;
using ArcCosine =
    Function<kToAngle, [](double x) { return std::abs(x) <= 1.0 ? std::optional(std::acos(x)) : std::nullopt; }>;
using ArcTangent2 = Function<kTwoSides, [](double y, double x) { return std::atan2(y, x); }>;
using WrapAngle = Function<kAngle, [](double x) {
  const double wrapped = std::remainder(x, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}>;
using RadiansToRatio = Function<kOfAngle, [](double x) { return x; }>;
using RatioToRadians = Function<kToAngle, [](double x) { return x; }>;

TAKT_PRIMITIVE(Sine, "arithmetic", "sin(input).");
TAKT_PRIMITIVE(Cosine, "arithmetic", "cos(input).");
TAKT_PRIMITIVE(Tangent, "arithmetic", "tan(input).");
TAKT_PRIMITIVE(ArcSine, "arithmetic", "The angle in [-pi/2, pi/2] whose sine is the input. Null outside [-1, 1].");
TAKT_PRIMITIVE(ArcCosine, "arithmetic", "The angle in [0, pi] whose cosine is the input. Null outside [-1, 1].");
TAKT_PRIMITIVE(ArcTangent2, "arithmetic", "The angle of the point (x, y); 0 for the origin.");
TAKT_PRIMITIVE(WrapAngle, "arithmetic", "The same angle in (-pi, pi].");
TAKT_PRIMITIVE(RadiansToRatio, "arithmetic", "The number of an angle without its unit: arc over radius.");
TAKT_PRIMITIVE(RatioToRadians, "arithmetic", "An angle from arc over radius.");

// -- Whole numbers ----------------------------------------------------------------------------------------------------

using MaybeInteger = std::optional<Integer>;

constexpr auto kWhole = [] {
  return ports({{"a", "", "left side"}, {"b", "", "right side"}}, {{"value", "", "the result"}});
};
constexpr auto kToWhole = [] { return ports({{"input", "1", "a number"}}, {{"value", "", "a whole number"}}); };
constexpr auto kToReal = [] { return ports({{"input", "", "a whole number"}}, {{"value", "1", "the same number"}}); };
constexpr auto kCount = [] { return ports({{"input", "", "a condition"}}, {{"value", "", "1 if true, 0 if false"}}); };

/// A rounded number, if the type can hold it.
MaybeInteger whole(double rounded) {
  constexpr double kTooLarge = 0x1p63;
  if (!(rounded >= -kTooLarge && rounded < kTooLarge)) return std::nullopt;
  return static_cast<Integer>(rounded);
}

/// Neither division exists for b = 0, nor for the one quotient that does not fit.
bool divides(Integer a, Integer b) { return b != 0 && !(b == -1 && a == std::numeric_limits<Integer>::min()); }

using AddIntegers = Function<kWhole, [](Integer a, Integer b) -> MaybeInteger {
  Integer sum = 0;
  return __builtin_add_overflow(a, b, &sum) ? std::nullopt : MaybeInteger(sum);
}>;
using SubtractIntegers = Function<kWhole, [](Integer a, Integer b) -> MaybeInteger {
  Integer difference = 0;
  return __builtin_sub_overflow(a, b, &difference) ? std::nullopt : MaybeInteger(difference);
}>;
using MultiplyIntegers = Function<kWhole, [](Integer a, Integer b) -> MaybeInteger {
  Integer product = 0;
  return __builtin_mul_overflow(a, b, &product) ? std::nullopt : MaybeInteger(product);
}>;
using DivideIntegers =
    Function<kWhole, [](Integer a, Integer b) { return divides(a, b) ? MaybeInteger(a / b) : std::nullopt; }>;
using ModuloIntegers = Function<kWhole, [](Integer a, Integer b) -> MaybeInteger {
  if (!divides(a, b)) return b == 0 ? std::nullopt : MaybeInteger(0);
  const Integer remainder = a % b;
  return remainder != 0 && (remainder < 0) != (b < 0) ? remainder + b : remainder;
}>;
using Floor = Function<kToWhole, [](double x) { return whole(std::floor(x)); }>;
using Ceiling = Function<kToWhole, [](double x) { return whole(std::ceil(x)); }>;
using Round = Function<kToWhole, [](double x) { return whole(std::round(x)); }>;
using IntegerToReal = Function<kToReal, [](Integer x) { return static_cast<double>(x); }>;
using BooleanToInteger = Function<kCount, [](Boolean x) { return static_cast<Integer>(x); }>;

TAKT_PRIMITIVE(AddIntegers, "arithmetic", "a + b. Null where it does not fit into 64 bits.");
TAKT_PRIMITIVE(SubtractIntegers, "arithmetic", "a - b. Null where it does not fit into 64 bits.");
TAKT_PRIMITIVE(MultiplyIntegers, "arithmetic", "a * b. Null where it does not fit into 64 bits.");
TAKT_PRIMITIVE(DivideIntegers, "arithmetic", "a / b without its fraction. Null if b is 0.");
TAKT_PRIMITIVE(ModuloIntegers, "arithmetic",
               "What is left of a after whole multiples of b, with the sign of b. Null if b is 0.");
TAKT_PRIMITIVE(Floor, "arithmetic", "The next whole number below. Null where it does not fit into 64 bits.");
TAKT_PRIMITIVE(Ceiling, "arithmetic", "The next whole number above. Null where it does not fit into 64 bits.");
TAKT_PRIMITIVE(Round, "arithmetic",
               "The nearest whole number, halves away from 0. Null where it does not fit into 64 bits.");
TAKT_PRIMITIVE(IntegerToReal, "arithmetic", "A whole number as a real one; beyond 2^53 the nearest.");
TAKT_PRIMITIVE(BooleanToInteger, "arithmetic", "1 if true, 0 if false.");

}  // namespace
}  // namespace takt::primitives::numbers
