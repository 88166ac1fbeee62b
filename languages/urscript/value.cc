#include "languages/urscript/value.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace takt::languages::urscript {

namespace {

/// An integer while it is one of 32 bits, else a real.
Value whole(std::int64_t value) {
  if (value >= std::numeric_limits<std::int32_t>::min() && value <= std::numeric_limits<std::int32_t>::max())
    return static_cast<std::int32_t>(value);
  return static_cast<double>(value);
}

std::optional<Value> calculate(Operator op, std::int64_t a, std::int64_t b) {
  switch (op) {
    case Operator::kAdd:
      return whole(a + b);
    case Operator::kSubtract:
      return whole(a - b);
    case Operator::kMultiply:
      return whole(a * b);
    case Operator::kModulo:
      return b == 0 ? std::nullopt : std::optional<Value>(whole(a % b));
    default:
      return std::nullopt;
  }
}

std::optional<Value> calculate(Operator op, double a, double b) {
  switch (op) {
    case Operator::kAdd:
      return a + b;
    case Operator::kSubtract:
      return a - b;
    case Operator::kMultiply:
      return a * b;
    case Operator::kDivide:
      return b == 0.0 ? std::nullopt : std::optional<Value>(a / b);
    case Operator::kModulo:
      return b == 0.0 ? std::nullopt : std::optional<Value>(std::fmod(a, b));
    default:
      return std::nullopt;
  }
}

std::optional<Value> compare(Operator op, double a, double b) {
  switch (op) {
    case Operator::kLess:
      return a < b;
    case Operator::kGreater:
      return a > b;
    case Operator::kLessEqual:
      return a <= b;
    case Operator::kGreaterEqual:
      return a >= b;
    default:
      return std::nullopt;
  }
}

/// A number; handles of threads are compared with numbers too.
std::optional<double> comparable(const Value& value) {
  if (const auto* handle = value.get<ThreadHandle>()) return handle->id;
  return value.number();
}

bool equal(const Value& a, const Value& b) {
  const auto x = comparable(a), y = comparable(b);
  if (x && y) return *x == *y;
  const auto* p = a.get<List>();
  const auto* q = b.get<List>();
  if (p == nullptr || q == nullptr) return a == b;
  if (p->size() != q->size()) return false;
  for (std::size_t i = 0; i < p->size(); ++i)
    if (!equal((*p)[i], (*q)[i])) return false;
  return true;
}

std::optional<Value> logic(Operator op, bool a, bool b) {
  switch (op) {
    case Operator::kAnd:
      return a && b;
    case Operator::kOr:
      return a || b;
    case Operator::kXor:
      return a != b;
    default:
      return std::nullopt;
  }
}

bool is_arithmetic(Operator op) { return op <= Operator::kModulo; }
bool is_logic(Operator op) { return op >= Operator::kAnd; }

std::optional<Value> each(Operator op, const List* a, const Value& b, const List* c, const Value& d) {
  const std::size_t size = a != nullptr ? a->size() : c->size();
  if (a != nullptr && c != nullptr && a->size() != c->size()) return std::nullopt;
  List out;
  for (std::size_t i = 0; i < size; ++i) {
    auto value = apply(op, a != nullptr ? (*a)[i] : b, c != nullptr ? (*c)[i] : d);
    if (!value) return std::nullopt;
    out.push_back(std::move(*value));
  }
  return Value(std::move(out));
}

template <class Range>
std::string joined(const Range& values) {
  std::string out;
  for (const auto& value : values) {
    if (!out.empty()) out += ", ";
    out += Value(value).text();
  }
  return out;
}

}  // namespace

std::optional<double> Value::number() const {
  if (const auto* integer = get<std::int32_t>()) return *integer;
  if (const auto* real = get<double>()) return *real;
  return std::nullopt;
}

std::optional<std::vector<double>> Value::numbers(std::size_t count) const {
  if (const auto* coordinates = get<Pose>(); coordinates != nullptr && count == coordinates->size())
    return std::vector<double>(coordinates->begin(), coordinates->end());
  const auto* list = get<List>();
  if (list == nullptr || list->size() != count) return std::nullopt;
  std::vector<double> out;
  for (const Value& entry : *list) {
    const auto number = entry.number();
    if (!number) return std::nullopt;
    out.push_back(*number);
  }
  return out;
}

std::optional<Pose> Value::pose() const {
  if (const auto* own = get<Pose>()) return *own;
  return std::nullopt;
}

std::optional<bool> Value::truth() const {
  if (const auto* boolean = get<bool>()) return *boolean;
  if (const auto value = number()) return *value != 0.0;
  if (const auto* handle = get<ThreadHandle>()) return handle->id != 0;
  return std::nullopt;
}

std::string Value::text() const {
  if (const auto* boolean = get<bool>()) return *boolean ? "True" : "False";
  if (const auto* integer = get<std::int32_t>()) return fmt::format("{}", *integer);
  if (const auto* real = get<double>()) return fmt::format("{:g}", *real);
  if (const auto* string = get<std::string>()) return *string;
  if (const auto* coordinates = get<Pose>()) return "p[" + joined(*coordinates) + "]";
  if (const auto* list = get<List>()) return "[" + joined(*list) + "]";
  if (const auto* handle = get<ThreadHandle>()) return fmt::format("{}", handle->id);
  return "None";
}

std::string_view Value::kind() const {
  static constexpr std::array<std::string_view, 8> kKinds = {"nothing",  "a Boolean", "an integer", "a real number",
                                                             "a string", "a pose",    "a list",     "a thread"};
  return kKinds[data_.index()];
}

Value to_list(const std::vector<double>& numbers) {
  List list;
  for (const double number : numbers) list.emplace_back(number);
  return list;
}

std::string_view name_of(Operator op) {
  static constexpr std::array<std::string_view, 14> kNames = {
      "+", "-", "*", "/", "%", "==", "!=", "<", ">", "<=", ">=", "and", "or", "xor"};
  return kNames[static_cast<std::size_t>(op)];
}

std::optional<Value> apply(Operator op, const Value& a, const Value& b) {
  if (op == Operator::kEqual) return equal(a, b);
  if (op == Operator::kNotEqual) return !equal(a, b);
  if (is_logic(op)) {
    const auto x = a.truth(), y = b.truth();
    return x && y ? logic(op, *x, *y) : std::nullopt;
  }
  // A sum with a text is a text, whatever the other side is.
  if (op == Operator::kAdd && (a.get<std::string>() != nullptr || b.get<std::string>() != nullptr))
    return Value(a.text() + b.text());
  const auto *p = a.get<List>(), *q = b.get<List>();
  if (is_arithmetic(op) && (p != nullptr || q != nullptr)) return each(op, p, a, q, b);
  const auto *i = a.get<std::int32_t>(), *j = b.get<std::int32_t>();
  // Division gives a real number, of two integers too.
  if (i != nullptr && j != nullptr && is_arithmetic(op) && op != Operator::kDivide)
    return calculate(op, std::int64_t{*i}, std::int64_t{*j});
  const auto x = comparable(a), y = comparable(b);
  if (!x || !y) return std::nullopt;
  return is_arithmetic(op) ? calculate(op, *x, *y) : compare(op, *x, *y);
}

std::optional<Value> negated(const Value& a) { return apply(Operator::kMultiply, a, Value(-1)); }

}  // namespace takt::languages::urscript
