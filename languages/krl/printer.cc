// A module as text again.
#include <array>

#include <fmt/format.h>

#include "languages/krl/parser.h"

namespace takt::languages::krl {
namespace {

using Kind = Statement::Kind;

constexpr std::array kOperatorWords{"",   "+",   "-",  "*",    "/",    ":", "==",    "<>",   "<",      "<=",    ">",
                                    ">=", "AND", "OR", "EXOR", "NOT ", "-", "B_AND", "B_OR", "B_EXOR", "B_NOT "};

std::string joined(const std::vector<ExpressionPtr>& parts, std::size_t first = 0) {
  std::string text;
  for (std::size_t i = first; i < parts.size(); ++i)
    text += (i > first ? ", " : "") + (parts[i] ? to_string(*parts[i]) : std::string());
  return text;
}

class Printer {
 public:
  void declarations(const std::vector<Declaration>& all) {
    for (const Declaration& one : all) {
      line("DECL " + std::string(one.is_global ? "GLOBAL " : "") + (one.is_constant ? "CONST " : "") + one.type + " " +
           one.name + (one.size.empty() ? "" : "[" + joined(one.size) + "]") +
           (!one.initial.empty() && one.initial.front().first.empty() ? "=" + to_string(*one.initial.front().second)
                                                                      : ""));
      for (const auto& [index, value] : one.initial) {
        if (index.empty()) continue;
        std::string at;
        for (const int i : index) at += (at.empty() ? "" : ",") + fmt::format("{}", i);
        line(one.name + "[" + at + "]=" + to_string(*value));
      }
    }
  }

  void type(const TypeDeclaration& one) {
    std::string text = one.is_enumeration ? "ENUM " + one.name + " " : "STRUC " + one.name + " ";
    for (std::size_t i = 0; i < one.constants.size(); ++i) text += (i > 0 ? ", " : "") + one.constants[i];
    for (std::size_t i = 0; i < one.fields.size(); ++i) {
      const Declaration& field = one.fields[i];
      text += (i > 0 ? ", " : "") + field.type + " " + field.name +
              (field.size.empty() ? "" : "[" + joined(field.size) + "]");
    }
    line(text);
  }

  void signal(const Signal& one) {
    line("SIGNAL " + one.name + " " + to_string(*one.first) + (one.last ? " TO " + to_string(*one.last) : ""));
  }

  void function(const Function& one) {
    std::string head = one.is_global ? "GLOBAL " : "";
    head += one.result.empty() ? "DEF " : "DEFFCT " + one.result + " ";
    head += one.name + "(";
    for (std::size_t i = 0; i < one.parameters.size(); ++i)
      head += (i > 0 ? ", " : "") + one.parameters[i].name + (one.parameters[i].is_array ? "[]" : "") +
              (one.parameters[i].is_out ? ":OUT" : ":IN");
    line(head + ")");
    ++depth_;
    declarations(one.declarations);
    --depth_;
    block(one.body);
    line(one.result.empty() ? "END" : "ENDFCT");
  }

  void line(const std::string& text) { text_ += std::string(static_cast<std::size_t>(2 * depth_), ' ') + text + "\n"; }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void block(const Block& statements) {
    ++depth_;
    for (const Statement& one : statements) statement(one);
    --depth_;
  }

  static std::string ending(const Statement& one) {
    std::string text;
    for (const std::string& word : one.approximation) text += " " + word;
    for (std::size_t i = 0; i < one.with.size(); ++i)
      text += (i > 0 ? ", " : " WITH ") + to_string(*one.with[i].first) + "=" + to_string(*one.with[i].second);
    return text;
  }

  static std::string simple(const Statement& one) {
    const auto text = [](const ExpressionPtr& value) { return value ? to_string(*value) : std::string(); };
    switch (one.kind) {
      case Kind::kAssign:
        return text(one.a) + "=" + text(one.b);
      case Kind::kCall:
        return text(one.a);
      case Kind::kPulse:
        return "PULSE(" + text(one.a) + ", " + text(one.b) + ", " + text(one.c) + ")";
      case Kind::kGoto:
        return "GOTO " + one.word;
      case Kind::kLabel:
        return one.word + ":";
      case Kind::kExit:
        return "EXIT";
      case Kind::kReturn:
        return one.a ? "RETURN " + text(one.a) : "RETURN";
      case Kind::kContinue:
        return "CONTINUE";
      case Kind::kWaitSeconds:
        return "WAIT SEC " + text(one.a);
      case Kind::kWaitFor:
        return "WAIT FOR " + text(one.a);
      case Kind::kBrake:
        return one.flag ? "BRAKE F" : "BRAKE";
      case Kind::kResume:
        return "RESUME";
      case Kind::kMotion:
        return one.word + " " + joined(one.goals) + (one.c ? ", CA " + text(one.c) : "") + ending(one) +
               (one.flag ? " #TOOL" : "");
      case Kind::kTrigger:
        return "TRIGGER WHEN " + one.word + "=" + text(one.a) + (one.flag ? " ONSTART" : "") + " DELAY=" + text(one.b) +
               " DO " + (one.body.empty() ? std::string() : simple(one.body.front())) +
               (one.c ? " PRIO=" + text(one.c) : "");
      case Kind::kInterruptDeclare:
        return std::string(one.flag ? "GLOBAL " : "") + "INTERRUPT DECL " + text(one.a) + " WHEN " + text(one.b) +
               " DO " + text(one.c);
      case Kind::kInterruptSwitch:
        return "INTERRUPT " + one.word + (one.a ? " " + text(one.a) : "");
      default:
        return "HALT";
    }
  }

  void statement(const Statement& one) {
    switch (one.kind) {
      case Kind::kIf:
        line("IF " + to_string(*one.a) + " THEN");
        block(one.body);
        if (one.flag) {
          line("ELSE");
          block(one.otherwise);
        }
        return line("ENDIF");
      case Kind::kLoop:
        return wrapped("LOOP", one, "ENDLOOP");
      case Kind::kWhile:
        return wrapped("WHILE " + to_string(*one.a), one, "ENDWHILE");
      case Kind::kRepeat:
        return wrapped("REPEAT", one, "UNTIL " + to_string(*one.a));
      case Kind::kFor:
        return wrapped("FOR " + to_string(*one.a) + "=" + to_string(*one.b) + " TO " + to_string(*one.c) +
                           (one.d ? " STEP " + to_string(*one.d) : ""),
                       one, "ENDFOR");
      case Kind::kSpline:
        return wrapped("SPLINE" + ending(one), one, "ENDSPLINE");
      case Kind::kSwitch:
        line("SWITCH " + to_string(*one.a));
        for (const Case& each : one.cases) {
          line(each.labels.empty() ? "DEFAULT" : "CASE " + joined(each.labels));
          block(each.body);
        }
        return line("ENDSWITCH");
      default:
        return line(simple(one));
    }
  }

  void wrapped(const std::string& head, const Statement& one, const std::string& end) {
    line(head);
    block(one.body);
    line(end);
  }

  std::string text_;
  int depth_ = 0;
};

}  // namespace

std::string to_string(const Expression& expression) {
  const auto part = [&](std::size_t i) { return to_string(*expression.parts[i]); };
  switch (expression.kind) {
    case Expression::Kind::kLiteral:
      return to_string(expression.value);
    case Expression::Kind::kName:
      return expression.name;
    case Expression::Kind::kField:
      return part(0) + "." + expression.name;
    case Expression::Kind::kIndex:
      return part(0) + "[" + joined(expression.parts, 1) + "]";
    case Expression::Kind::kCall:
      return expression.name + "(" + joined(expression.parts) + ")";
    case Expression::Kind::kUnary:
      return "(" + std::string(kOperatorWords.at(static_cast<std::size_t>(expression.op))) + part(0) + ")";
    case Expression::Kind::kBinary:
      return "(" + part(0) + " " + kOperatorWords.at(static_cast<std::size_t>(expression.op)) + " " + part(1) + ")";
    case Expression::Kind::kAggregate:
      break;
  }
  std::string text = "{" + (expression.name.empty() ? std::string() : expression.name + ": ");
  for (std::size_t i = 0; i < expression.parts.size(); ++i)
    text += (i > 0 ? ", " : "") + expression.names[i] + " " + part(i);
  return text + "}";
}

std::string print_source(const Module& module) {
  Printer printer;
  for (const Function& one : module.functions) printer.function(one);
  return printer.take();
}

std::string print_data(const Module& module) {
  Printer printer;
  printer.line("DEFDAT " + module.name);
  for (const TypeDeclaration& one : module.types) printer.type(one);
  for (const Signal& one : module.signals) printer.signal(one);
  printer.declarations(module.data);
  printer.line("ENDDAT");
  return printer.take();
}

}  // namespace takt::languages::krl
