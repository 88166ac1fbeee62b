// What an expression is worth. Checking types is the same as evaluating with nothing known.
#include "core/program/language/expression.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include <fmt/format.h>

#include "core/expression/moving_frames.h"
#include "core/program/language/text_limit.h"

namespace takt::program {
namespace {

using Node = ExpressionNode;
using Kind = Type::Kind;

/// Does a letter of Function::arguments allow this type?
bool fits(char letter, const Type& type) {
  const auto number_in = [&](std::string_view unit) {
    return type.is(Kind::kNumber) && (type.kind == Kind::kUnknown || type.unit == unit_dimension(unit));
  };
  switch (letter) {
    case 'b':
      return type.is(Kind::kBoolean);
    case 'n':
      return type.is(Kind::kNumber);
    case 'd':
      return number_in("1");
    case 'l':
      return number_in("m");
    case 'a':
      return number_in("rad");
    case 't':
      return type.is(Kind::kText);
    case 'p':
      return type.is(Kind::kPose);
    case 'L':
      return type.is(Kind::kList);
    default:
      return true;
  }
}

std::string_view words_for(char letter) {
  switch (letter) {
    case 'b':
      return "true or false";
    case 'n':
      return "a number";
    case 'd':
      return "a number without a unit";
    case 'l':
      return "a length, such as 0.1[m]";
    case 'a':
      return "an angle, such as 90[deg]";
    case 't':
      return "a text";
    case 'p':
      return "a pose";
    case 'L':
      return "a list";
    default:
      return "anything";
  }
}

/// The unit of a product; the dimension of one that goes beyond any measure is refused.
std::optional<net::Dimension> product_unit(const Type& a, const Type& b, int power) {
  const net::Dimension unit = a.unit.times(b.unit, {power, 1});
  return unit.valid() ? std::optional(unit) : std::nullopt;
}

/// Three-valued (row N2): `decisive` on one side decides.
Value logic(const Value& a, const Value& b, bool decisive) {
  if ((!a.null() && a.boolean() == decisive) || (!b.null() && b.boolean() == decisive)) return Value::of(decisive);
  return a.null() || b.null() ? Value::unknown(Type::boolean()) : Value::of(!decisive);
}

bool same(const Value& a, const Value& b) {
  if (a.type.is(Kind::kPose) && a.data.index() == 4) {
    return b.data.index() == 4 && a.pose().matrix() == b.pose().matrix();
  }
  if (a.data.index() != b.data.index()) return false;
  if (a.data.index() == 5) {
    return std::ranges::equal(a.list(), b.list(), [](const Value& x, const Value& y) { return same(x, y); });
  }
  if (a.data.index() == 1) return a.boolean() == b.boolean();
  if (a.data.index() == 2) return a.number() == b.number();
  return a.data.index() == 3 && a.text() == b.text();
}

class Evaluator {
 public:
  Evaluator(const std::string& text, const EvalContext& eval_context, Diagnostics& diagnostics)
      : text_(text), sight_(eval_context), diagnostics_(diagnostics) {}

  Value at(const Node& node) {
    switch (node.kind) {
      case Node::Kind::kConstant:
        return node.value;
      case Node::Kind::kVariable:
        return variable(node);
      case Node::Kind::kCall:
        return call(node);
      case Node::Kind::kNegate:
        return negated(node);
      case Node::Kind::kNot: {
        const Value value = boolean(node, at(node.children[0]));
        return value.null() ? value : Value::of(!value.boolean());
      }
      case Node::Kind::kBinary:
        return binary(node);
      case Node::Kind::kIndex:
        return element(node);
      case Node::Kind::kList:
        return list(node);
    }
    return {};
  }

 private:
  Value wrong(const Node& node, const std::string& message, const std::string& hint = {},
              Code code = Code::kTypeMismatch) {
    diagnostics_.error(code, {}, fmt::format("in '{}', character {}: {}", text_, node.at + 1, message), hint);
    return {};
  }

  Value variable(const Node& node) {
    if (const Variable* variable = sight_.scope ? sight_.scope->find(node.name) : nullptr) {
      // A value that is not known has the type of its variable.
      return sight_.mode == EvalContext::Mode::kCheck ? Value::unknown(variable->type) : variable->value;
    }
    const auto names = sight_.scope ? sight_.scope->names() : std::vector<std::string>{};
    return wrong(node, fmt::format("there is no variable '{}'", node.name), nearest_choice(node.name, names),
                 Code::kUnknownName);
  }

  Value boolean(const Node& node, Value value) {
    if (value.type.is(Kind::kBoolean)) return value.null() ? Value::unknown(Type::boolean()) : value;
    wrong(node, fmt::format("'{}' accepts true or false, not a {}", node.name, to_string(value.type)),
          "a comparison, such as x > 0.1[m]");
    return Value::unknown(Type::boolean());
  }

  Value negated(const Node& node) {
    Value value = at(node.children[0]);
    if (!value.type.is(Kind::kNumber))
      return wrong(node, fmt::format("a {} has no sign", to_string(value.type)), "a number");
    if (!value.null()) value.data = -value.number();
    return value;
  }

  Value list(const Node& node) {
    std::vector<Value> values;
    for (const Node& child : node.children) values.push_back(at(child));
    Value result = Value::of(std::move(values));
    for (const Value& value : result.list()) {
      if (!accepts(result.type.element.front(), value.type) || result.type.element.front().kind == Kind::kUnknown) {
        if (value.type.kind == Kind::kUnknown) continue;
        return wrong(node, "the elements are of different types", "one type, one unit");
      }
    }
    return result;
  }

  Value element(const Node& node) {
    const Value list = at(node.children[0]);
    const Value index = at(node.children[1]);
    if (!list.type.is(Kind::kList))
      return wrong(node, fmt::format("a {} has no elements", to_string(list.type)), "a list before the [");
    if (!fits('d', index.type))
      return wrong(node, fmt::format("a {} is not an index", to_string(index.type)), "a number without a unit, from 0");
    const Type type = list.type.kind == Kind::kList ? list.type.element.front() : Type{};
    if (list.null() || index.null()) return Value::unknown(type);
    const double i = index.number();
    const double size = static_cast<double>(list.list().size());
    // A rehearsal may not have filled the list.
    if ((i < 0 || i >= size) && !sight_.running()) return Value::unknown(type);
    if (i != std::floor(i) || i < 0 || i >= size) {
      return wrong(node, fmt::format("element {:g} of {:g}", i, size), "whole numbers from 0", Code::kOutOfRange);
    }
    return list.list()[static_cast<std::size_t>(i)];
  }

  Value binary(const Node& node) {
    Value a = at(node.children[0]);
    Value b = at(node.children[1]);
    if (node.name == "and" || node.name == "or") {
      a = boolean(node, std::move(a));
      return logic(a, boolean(node, std::move(b)), node.name == "or");
    }
    if (node.name == "==" || node.name == "!=") return equality(node, a, b);
    if (node.name == "<" || node.name == "<=" || node.name == ">" || node.name == ">=") return order(node, a, b);
    if (node.name == "+" && a.type.kind == Kind::kText && b.type.is(Kind::kText)) return joined(node, a, b);
    if (node.name == "*" && a.type.kind == Kind::kPose && b.type.is(Kind::kPose)) {
      return a.null() || b.null() ? Value::unknown(Type::pose()) : Value::of(Eigen::Isometry3d(a.pose() * b.pose()));
    }
    return arithmetic(node, a, b);
  }

  /// A text that doubles itself in a loop would fill the memory within seconds.
  Value joined(const Node& node, const Value& a, const Value& b) {
    if (a.null() || b.null()) return Value::unknown(Type::text());
    const std::size_t size = a.text().size() + b.text().size();
    if (size <= kMostTextBytes) return Value::of(a.text() + b.text());
    wrong(node, fmt::format("a text of {} bytes", size), fmt::format("at most {}", kMostTextBytes), Code::kTooLarge);
    return Value::unknown(Type::text());
  }

  Value equality(const Node& node, const Value& a, const Value& b) {
    if (common(a.type, b.type).kind == Kind::kUnknown && a.type.kind != Kind::kUnknown &&
        b.type.kind != Kind::kUnknown) {
      return mismatch(node, a, b, Type::boolean());
    }
    if (a.null() || b.null()) return Value::unknown(Type::boolean());
    return Value::of(same(a, b) == (node.name == "=="));
  }

  Value order(const Node& node, const Value& a, const Value& b) {
    if (!a.type.is(Kind::kNumber) || !b.type.is(Kind::kNumber) || !one_unit(a, b)) {
      return mismatch(node, a, b, Type::boolean());
    }
    if (a.null() || b.null()) return Value::unknown(Type::boolean());
    const double x = a.number(), y = b.number();
    return Value::of(node.name == "<" ? x < y : node.name == "<=" ? x <= y : node.name == ">" ? x > y : x >= y);
  }

  static bool one_unit(const Value& a, const Value& b) {
    return a.type.kind == Kind::kUnknown || b.type.kind == Kind::kUnknown || a.type.unit == b.type.unit;
  }

  Value mismatch(const Node& node, const Value& a, const Value& b, Type result) {
    wrong(node, fmt::format("'{}' joins a {} and a {}", node.name, to_string(a.type), to_string(b.type)),
          "two numbers of one unit, such as 0.1[m]; for '+' two texts too; for '*' two poses too");
    return Value::unknown(std::move(result));
  }

  Value arithmetic(const Node& node, const Value& a, const Value& b) {
    const char sign = node.name.front();
    const bool scales = sign == '*' || sign == '/';
    if (!a.type.is(Kind::kNumber) || !b.type.is(Kind::kNumber) || (!scales && !one_unit(a, b))) {
      return mismatch(node, a, b, {});
    }
    const bool open = a.type.kind == Kind::kUnknown || b.type.kind == Kind::kUnknown;
    const auto unit = scales ? product_unit(a.type, b.type, sign == '*' ? 1 : -1) : std::optional(a.type.unit);
    if (!unit) return wrong(node, "this unit is beyond any measure", "magnitude(x) gives the number without its unit");
    const Type type = open ? Type{} : Type::number(*unit);
    if (a.null() || b.null()) return Value::unknown(type);
    const double value = compute(sign, a.number(), b.number());
    if (!std::isfinite(value))
      return wrong(node, fmt::format("{:g} {} {:g} is not a number", a.number(), sign, b.number()),
                   "select(condition, a, b) has another form");
    return Value{type.kind == Kind::kNumber ? type : Type::number(*unit), value};
  }

  static double compute(char sign, double a, double b) {
    switch (sign) {
      case '+':
        return a + b;
      case '-':
        return a - b;
      case '*':
        return a * b;
      case '/':
        return a / b;
      default:
        return a - b * std::floor(a / b);
    }
  }

  Value call(const Node& node) {
    std::vector<Value> arguments;
    for (const Node& child : node.children) arguments.push_back(at(child));
    const auto found = std::ranges::find(functions(), node.name, &Function::name);
    if (found == functions().end()) {
      std::vector<std::string> names;
      for (const Function& function : functions()) names.emplace_back(function.name);
      return wrong(node, fmt::format("there is no function '{}'", node.name), nearest_choice(node.name, names, 40),
                   Code::kUnknownName);
    }
    if (!arguments_fit(node, *found, arguments)) return {};
    std::vector<std::string> errors;
    const bool all_known = std::ranges::none_of(arguments, &Value::null);
    Function::Call call{sight_, arguments, errors, all_known};
    Value value = found->call(call);
    for (const std::string& error : errors) wrong(node, error, std::string(found->doc));
    return value;
  }

  bool arguments_fit(const Node& node, const Function& function, const std::vector<Value>& arguments) {
    const std::size_t optional = function.arguments.find('?');
    const std::size_t most = function.arguments.size() - (optional == std::string_view::npos ? 0 : 1);
    const std::size_t least = std::min(optional, most);
    if (arguments.size() < least || arguments.size() > most) {
      wrong(node,
            fmt::format("'{}' accepts {} arguments, not {}", function.name,
                        least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most),
                        arguments.size()),
            std::string(function.doc));
      return false;
    }
    bool fit = true;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      const char letter = function.arguments[i >= optional ? i + 1 : i];
      if (fits(letter, arguments[i].type)) continue;
      wrong(node.children[i],
            fmt::format("'{}' accepts {}, not a {}", function.name, words_for(letter), to_string(arguments[i].type)),
            std::string(function.doc));
      fit = false;
    }
    return fit;
  }

  const std::string& text_;
  const EvalContext& sight_;
  Diagnostics& diagnostics_;
};

}  // namespace

namespace {

/// A frame that an argument names moves, or it is unknown before which one it will name.
bool names_what_moves(const Node& argument, const expression::Cell& cell) {
  const bool named = argument.kind == Node::Kind::kConstant && argument.value.type.kind == Kind::kText;
  return !named || expression::moves(cell.frames, argument.value.text(), world::FrameGraph::kWorld);
}

bool changes(const Node& node, const expression::Cell& cell) {
  const auto inside = [&](const Node& child) { return changes(child, cell); };
  if (std::ranges::any_of(node.children, inside)) return true;
  if (node.kind != Node::Kind::kCall) return false;
  const auto function = std::ranges::find(functions(), node.name, &Function::name);
  if (function == functions().end()) return false;
  if (function->changes != Function::Changes::kFrames) return function->changes == Function::Changes::kAlways;
  return std::ranges::any_of(node.children, [&](const Node& child) { return names_what_moves(child, cell); });
}

}  // namespace

bool Expression::changes(const expression::Cell& cell) const { return program::changes(*root_, cell); }

Value Expression::evaluate(const EvalContext& eval_context, Diagnostics& diagnostics) const {
  return Evaluator(text_, eval_context, diagnostics).at(*root_);
}

}  // namespace takt::program
