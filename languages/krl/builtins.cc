#include "languages/krl/builtins.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace takt::languages::krl {
namespace {

constexpr double kToRadians = std::numbers::pi / 180.0;

std::string real(double value, Value& result) {
  if (!std::isfinite(value)) return "the result is out of range";
  result = Value::of(value);
  return {};
}

template <class Function>
std::string of_number(std::span<const Value> arguments, Value& result, Function function) {
  if (!arguments[0].is_number()) return "unexpected argument " + to_string(arguments[0]);
  return real(function(arguments[0].number()), result);
}

std::string absolute(std::span<const Value> arguments, Value& result) {
  if (arguments[0].kind == Value::Kind::kInt) {
    result = Value::of(std::abs(arguments[0].integer));
    return {};
  }
  return of_number(arguments, result, [](double x) { return std::abs(x); });
}
std::string root(std::span<const Value> arguments, Value& result) {
  return of_number(arguments, result, [](double x) { return std::sqrt(x); });
}
std::string sine(std::span<const Value> arguments, Value& result) {
  return of_number(arguments, result, [](double x) { return std::sin(x * kToRadians); });
}
std::string cosine(std::span<const Value> arguments, Value& result) {
  return of_number(arguments, result, [](double x) { return std::cos(x * kToRadians); });
}
std::string tangent(std::span<const Value> arguments, Value& result) {
  return of_number(arguments, result, [](double x) { return std::tan(x * kToRadians); });
}
std::string arc_cosine(std::span<const Value> arguments, Value& result) {
  return of_number(arguments, result, [](double x) { return std::acos(x) / kToRadians; });
}
std::string arc_tangent(std::span<const Value> arguments, Value& result) {
  if (!arguments[1].is_number()) return "unexpected argument " + to_string(arguments[1]);
  return of_number(arguments, result, [&](double y) { return std::atan2(y, arguments[1].number()) / kToRadians; });
}
std::string inverse(std::span<const Value> arguments, Value& result) {
  if (!arguments[0].has("X")) return "unexpected argument " + to_string(arguments[0]);
  result = arguments[0];
  set_pose(result, to_pose(arguments[0], Eigen::Isometry3d::Identity()).inverse());
  return {};
}

constexpr std::array<Builtin, 8> kBuiltins{{{"ABS", 1, absolute},
                                            {"SQRT", 1, root},
                                            {"SIN", 1, sine},
                                            {"COS", 1, cosine},
                                            {"TAN", 1, tangent},
                                            {"ACOS", 1, arc_cosine},
                                            {"ATAN2", 2, arc_tangent},
                                            {"INV_POS", 1, inverse}}};

std::string arithmetic(Operator op, const Value& left, const Value& right, Value& result) {
  if (left.kind != Value::Kind::kInt || right.kind != Value::Kind::kInt) {
    const double a = left.number();
    const double b = right.number();
    if (op == Operator::kDivide && b == 0.0) return "division by 0";
    return real(op == Operator::kAdd        ? a + b
                : op == Operator::kSubtract ? a - b
                : op == Operator::kMultiply ? a * b
                                            : a / b,
                result);
  }
  const std::int64_t a = left.integer;
  const std::int64_t b = right.integer;
  if (op == Operator::kDivide && b == 0) return "division by 0";
  const std::int64_t value = op == Operator::kAdd        ? a + b
                             : op == Operator::kSubtract ? a - b
                             : op == Operator::kMultiply ? a * b
                                                         : a / b;
  if (std::abs(value) > 2147483648) return fmt::format("{} is out of the range of INT", value);
  result = Value::of(value);
  return {};
}

std::string compare(Operator op, const Value& left, const Value& right, Value& result) {
  if (op == Operator::kEqual || op == Operator::kNotEqual) {
    const bool alike = (left.is_number() && right.is_number()) || left.kind == right.kind;
    if (!alike) return fmt::format("{} is not compared with {}", to_string(left), to_string(right));
    result = Value::of(equal(left, right) == (op == Operator::kEqual));
    return {};
  }
  if (!left.is_number() || !right.is_number())
    return fmt::format("{} is not compared with {}", to_string(left), to_string(right));
  const double a = left.number();
  const double b = right.number();
  result = Value::of(op == Operator::kLess        ? a < b
                     : op == Operator::kLessEqual ? a <= b
                     : op == Operator::kGreater   ? a > b
                                                  : a >= b);
  return {};
}

std::string logic(Operator op, bool a, bool b, Value& result) {
  result = Value::of(op == Operator::kAnd ? a && b : op == Operator::kOr ? a || b : a != b);
  return {};
}

std::string bits(Operator op, std::int64_t a, std::int64_t b, Value& result) {
  const std::int64_t value = op == Operator::kBitAnd ? (a & b) : op == Operator::kBitOr ? (a | b) : (a ^ b);
  result = Value::of(static_cast<std::int64_t>(static_cast<std::int32_t>(value)));
  return {};
}

std::string geometric(const Value& left, const Value& right, Value& result) {
  if (!left.has("X") || !right.has("X"))
    return fmt::format("':' joins frames, not {} and {}", to_string(left), to_string(right));
  const Eigen::Isometry3d none = Eigen::Isometry3d::Identity();
  result = right;
  set_pose(result, to_pose(left, none) * to_pose(right, none));
  return {};
}

}  // namespace

const Builtin* find_builtin(std::string_view name) {
  const auto found = std::ranges::find(kBuiltins, name, &Builtin::name);
  return found == kBuiltins.end() ? nullptr : &*found;
}

bool equal(const Value& left, const Value& right) {
  if (left.is_number() && right.is_number()) return left.number() == right.number();
  if (left.kind != right.kind) return false;
  switch (left.kind) {
    case Value::Kind::kBool:
      return left.truth == right.truth;
    case Value::Kind::kText:
    case Value::Kind::kEnum:
      return left.text == right.text;
    case Value::Kind::kStructure:
    case Value::Kind::kArray:
      return std::ranges::equal(left.parts, right.parts, equal);
    default:
      return true;
  }
}

std::string operate(Operator op, const Value& left, const Value& right, Value& result) {
  if (left.nothing() || right.nothing()) return "a value was never set";
  const bool numbers = left.is_number() && right.is_number();
  const bool integers = left.kind == Value::Kind::kInt && right.kind == Value::Kind::kInt;
  const bool truths = left.kind == Value::Kind::kBool && right.kind == Value::Kind::kBool;
  switch (op) {
    case Operator::kGeometric:
      return geometric(left, right, result);
    case Operator::kEqual:
    case Operator::kNotEqual:
    case Operator::kLess:
    case Operator::kLessEqual:
    case Operator::kGreater:
    case Operator::kGreaterEqual:
      return compare(op, left, right, result);
    case Operator::kAnd:
    case Operator::kOr:
    case Operator::kExor:
      if (truths) return logic(op, left.truth, right.truth, result);
      break;
    case Operator::kBitAnd:
    case Operator::kBitOr:
    case Operator::kBitExor:
      if (integers) return bits(op, left.integer, right.integer, result);
      break;
    default:
      if (numbers) return arithmetic(op, left, right, result);
  }
  return fmt::format("{} and {} do not fit this operator", to_string(left), to_string(right));
}

std::string operate(Operator op, const Value& operand, Value& result) {
  if (operand.nothing()) return "a value was never set";
  if (op == Operator::kNot && operand.kind == Value::Kind::kBool) {
    result = Value::of(!operand.truth);
  } else if (op == Operator::kBitNot && operand.kind == Value::Kind::kInt) {
    result = Value::of(~operand.integer);
  } else if (op == Operator::kNegate && operand.kind == Value::Kind::kInt) {
    result = Value::of(-operand.integer);
  } else if (op == Operator::kNegate && operand.kind == Value::Kind::kReal) {
    result = Value::of(-operand.real);
  } else {
    return to_string(operand) + " does not fit this operator";
  }
  return {};
}

}  // namespace takt::languages::krl
