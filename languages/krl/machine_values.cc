// Values: what expressions are worth, and where variables are.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "languages/krl/builtins.h"
#include "languages/krl/lexer.h"
#include "languages/krl/machine.h"

namespace takt::languages::krl {
namespace {

std::int64_t count_elements(const Value& value) {
  std::int64_t count = 1;
  for (const Value& part : value.parts) count += count_elements(part);
  return count;
}

}  // namespace

void Machine::fail(const TextLocation& at, Code code, std::string message, std::string hint) {
  if (failed()) return;
  error_at(diagnostics_, program_.modules[static_cast<std::size_t>(module_)].file, at, code, std::move(message),
           std::move(hint));
}

Value& Machine::shared(std::string_view name) {
  const std::size_t last = program_.modules.size() - 1;
  const auto& names = program_.variables[last];
  const auto found = std::ranges::find(names, name, &Variable::name);
  return modules_[last][static_cast<std::size_t>(found - names.begin())];
}

Value* Machine::place(const Expression& one, Type* type) {
  switch (one.kind) {
    case Expression::Kind::kName: {
      if (one.where == Expression::Where::kLocal) {
        if (frames_.empty()) break;
        Frame& frame = frames_.back();
        const auto& known = program_.functions[static_cast<std::size_t>(frame.function)].locals;
        const auto slot = static_cast<std::size_t>(one.slot);
        if (type != nullptr) *type = known[slot].type;
        return &frame.locals[slot];
      }
      if (one.where != Expression::Where::kModule) break;
      const auto module = static_cast<std::size_t>(one.module);
      const auto slot = static_cast<std::size_t>(one.slot);
      if (type != nullptr) *type = program_.variables[module][slot].type;
      return &modules_[module][slot];
    }
    case Expression::Kind::kField: {
      Value* const whole = place(*one.parts[0], nullptr);
      if (whole == nullptr) return nullptr;
      const int at = whole->structure != nullptr ? whole->structure->find(one.name) : -1;
      if (at < 0) {
        fail(one.at, Code::kUnknownName, fmt::format("there is no component '{}'", one.name),
             "Use a component of the structure");
        return nullptr;
      }
      if (type != nullptr) *type = whole->structure->fields[static_cast<std::size_t>(at)].type;
      return &whole->parts[static_cast<std::size_t>(at)];
    }
    case Expression::Kind::kIndex:
      return element(one, place(*one.parts[0], type));
    default:
      break;
  }
  fail(one.at, Code::kWrongType, "this is no variable", "Use a variable");
  return nullptr;
}

Value* Machine::element(const Expression& one, Value* array) {
  if (array == nullptr || one.parts.size() == 1) return array;
  if (array->kind != Value::Kind::kArray || array->size.size() != one.parts.size() - 1) {
    fail(one.at, Code::kWrongSize, fmt::format("an array with {} indices is none", one.parts.size() - 1),
         "Give as many indices as it was declared with");
    return nullptr;
  }
  std::size_t at = 0;
  for (std::size_t i = 0; i < array->size.size(); ++i) {
    const double index = number(*one.parts[i + 1]);
    if (failed()) return nullptr;
    if (!(index >= 1.0 && index <= array->size[i])) {
      fail(one.at, Code::kOutOfRange, fmt::format("index {} is not from 1 to {}", index, array->size[i]),
           "Use an index that the array has");
      return nullptr;
    }
    at = at * static_cast<std::size_t>(array->size[i]) + static_cast<std::size_t>(std::llround(index)) - 1;
  }
  return &array->parts[at];
}

Value Machine::evaluate(const Expression& one, const Structure* wanted) {
  if (failed()) return {};
  Value result;
  std::string wrong;
  switch (one.kind) {
    case Expression::Kind::kLiteral:
      return one.value;
    case Expression::Kind::kAggregate:
      return evaluate_aggregate(one, wanted);
    case Expression::Kind::kName:
    case Expression::Kind::kIndex:
    case Expression::Kind::kField: {
      const Expression* root = &one;
      while (root->kind == Expression::Kind::kField || root->kind == Expression::Kind::kIndex)
        root = root->parts[0].get();
      if (root->where == Expression::Where::kLive) {
        if (one.kind == Expression::Kind::kField) {
          Value whole = evaluate(*one.parts[0]);
          const int at = whole.structure != nullptr ? whole.structure->find(one.name) : -1;
          if (at >= 0) return whole.parts[static_cast<std::size_t>(at)];
          fail(one.at, Code::kUnknownName, fmt::format("there is no component '{}'", one.name),
               "Use X, Y, Z, A, B, C or the axes");
          return {};
        }
        std::optional<std::int64_t> index;
        if (one.kind == Expression::Kind::kIndex && one.parts.size() == 2) index = std::llround(number(*one.parts[1]));
        return failed() ? Value() : evaluate_live(static_cast<Live>(root->live), index, one.at);
      }
      const Value* const found = place(one, nullptr);
      if (found == nullptr) return {};
      if (!found->parts.empty()) copies_ += count_elements(*found);
      return *found;
    }
    case Expression::Kind::kCall: {
      if (one.where == Expression::Where::kFunction)
        return one.slot >= 0 ? frames_.back().locals[static_cast<std::size_t>(one.slot)] : Value();
      std::vector<Value> arguments;
      for (const ExpressionPtr& part : one.parts) arguments.push_back(evaluate(*part));
      if (failed()) return {};
      wrong = find_builtin(one.name)->call(arguments, result);
      break;
    }
    case Expression::Kind::kUnary:
      wrong = operate(one.op, evaluate(*one.parts[0]), result);
      break;
    case Expression::Kind::kBinary:
      wrong = operate(one.op, evaluate(*one.parts[0]), evaluate(*one.parts[1]), result);
      break;
  }
  if (!wrong.empty()) fail(one.at, Code::kInvalidValue, wrong, "Check the values");
  return result;
}

Value Machine::evaluate_aggregate(const Expression& one, const Structure* wanted) {
  const Structure* structure = one.name.empty() ? wanted : program_.structure(one.name);
  if (structure == nullptr && one.name.empty()) {
    const bool axes = std::ranges::any_of(one.names, [](const std::string& name) { return name == "A1"; }) ||
                      (!one.names.empty() && std::ranges::all_of(one.names, [](const std::string& name) {
                        return name.size() == 2 && (name[0] == 'A' || name[0] == 'E');
                      }));
    structure = program_.structure(axes ? "E6AXIS" : "E6POS");
  }
  if (structure == nullptr) {
    fail(one.at, Code::kUnknownName, fmt::format("there is no structure '{}'", one.name), "Declare it");
    return {};
  }
  std::int64_t left = kMostElements;
  Value made = make_value({Type::Kind::kStructure, structure, nullptr}, {}, left);
  for (std::size_t i = 0; i < one.parts.size() && !failed(); ++i) {
    const int at = structure->find(one.names[i]);
    if (at < 0) {
      std::vector<std::string> names;
      for (const Field& field : structure->fields) names.push_back(field.name);
      fail(one.at, Code::kUnknownName, fmt::format("{} has no component '{}'", structure->name, one.names[i]),
           nearest_choice(one.names[i], names));
      break;
    }
    const Field& field = structure->fields[static_cast<std::size_t>(at)];
    const Value value = evaluate(*one.parts[i], field.type.structure);
    if (failed()) break;
    const std::string wrong = assign(made.parts[static_cast<std::size_t>(at)], field.type, value);
    if (!wrong.empty()) fail(one.parts[i]->at, Code::kWrongType, wrong, "Give a value of its type");
  }
  return made;
}

Value Machine::evaluate_live(Live live, std::optional<std::int64_t> number, const TextLocation& at) {
  std::int64_t left = kMostElements;
  asked_ = true;
  if (live == Live::kAxes || live == Live::kPosition) {
    const std::vector<double> axes = host_.axes();
    Value made = make_value(
        {Type::Kind::kStructure, program_.structure(live == Live::kAxes ? "E6AXIS" : "E6POS"), nullptr}, {}, left);
    if (live == Live::kAxes) {
      for (std::size_t i = 0; i < axes.size(); ++i)
        if (const int part = made.structure->find(host_.axis_names()[i]); part >= 0)
          made.parts[static_cast<std::size_t>(part)] = Value::of(axes[i]);
      return made;
    }
    const Eigen::Isometry3d none = Eigen::Isometry3d::Identity();
    set_pose(made, to_pose(shared("$BASE"), none).inverse() * host_.flange(axes) * to_pose(shared("$TOOL"), none));
    return made;
  }
  if (!number) {
    fail(at, Code::kWrongType, "a signal without a number", "Give its number in [ ]");
    return {};
  }
  if (live == Live::kTimer || live == Live::kTimerStop) {
    const Timer& timer = timers_[std::clamp<std::int64_t>(*number, 0, 1000)];
    if (live == Live::kTimerStop) return Value::of(!timer.runs);
    const double value = timer.value + (timer.runs ? (host_.now() - timer.since) * 1000.0 : 0.0);
    return Value::of(static_cast<std::int64_t>(std::llround(std::min(value, 2147483647.0))));
  }
  if (live == Live::kCyclicFlag) {
    const auto found = cyclic_.find(*number);
    if (found == cyclic_.end()) return Value::of(false);
    constexpr int kMost = 16;
    if (++cyclic_depth_ > kMost) {
      fail(at, Code::kInvalidValue, "cyclic flags that depend on each other", "Remove the circle");
      return {};
    }
    Value value = evaluate(*found->second);
    --cyclic_depth_;
    return value;
  }
  const std::optional<double> value =
      host_.read(live, static_cast<int>(std::clamp<std::int64_t>(*number, -1, 1 << 20)));
  if (!value) {
    fail(at, Code::kUnknownName, fmt::format("there is no signal {} here", *number),
         "Name it in the map of the program");
    return {};
  }
  const bool digital = live == Live::kIn || live == Live::kOut;
  return digital ? Value::of(*value != 0.0) : Value::of(*value);
}

double Machine::number(const Expression& one) {
  const Value value = evaluate(one);
  if (failed()) return 0.0;
  if (!value.is_number()) {
    fail(one.at, Code::kWrongType, fmt::format("unexpected {} where a number belongs", to_string(value)),
         "Give a number");
    return 0.0;
  }
  return value.number();
}

bool Machine::truth(const Expression& one) {
  const Value value = evaluate(one);
  if (failed()) return false;
  if (value.kind != Value::Kind::kBool)
    fail(one.at, Code::kWrongType, fmt::format("unexpected {} where a condition belongs", to_string(value)),
         "Give a BOOL");
  return value.truth;
}

}  // namespace takt::languages::krl
