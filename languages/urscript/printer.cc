// A script as text again: one statement a line, and no bracket that is not needed, so that it nests no deeper.
#include <fmt/format.h>

#include "languages/urscript/syntax.h"

namespace takt::languages::urscript {

namespace {

class Printer {
 public:
  std::string print(const Script& script) {
    if (script.bare) {
      // A definition at the very beginning would be the program.
      if (script.body.empty()) line(";");
      print_block(script.body);
      for (const Function& one : script.functions) print_function(one);
      return std::move(out_);
    }
    line(fmt::format("{} {}():", script.secondary ? "sec" : "def", script.name));
    ++depth_;
    for (const Function& one : script.functions) print_function(one);
    print_block(script.body);
    --depth_;
    line("end");
    return std::move(out_);
  }

 private:
  using Kind = Expression::Kind;

  void line(const std::string& text) { out_ += std::string(depth_ * 2, ' ') + text + "\n"; }

  void print_function(const Function& function) {
    std::string parameters;
    for (const Parameter& one : function.parameters) {
      if (!parameters.empty()) parameters += ", ";
      parameters += one.name;
      if (one.fallback) parameters += "=" + literal(*one.fallback);
    }
    line(fmt::format("{} {}({}):", function.is_thread ? "thread" : "def", function.name, parameters));
    print_body(function.body);
    line("end");
  }

  void print_body(const Block& block) {
    ++depth_;
    print_block(block);
    --depth_;
  }
  void print_block(const Block& block) {
    for (const Statement& one : block) print_statement(one);
  }

  void print_statement(const Statement& one) {
    using enum Statement::Kind;
    const std::string value = one.value != nullptr ? text(*one.value) : std::string();
    switch (one.kind) {
      case kExpression:
        return line(value);
      case kAssign:
        return line(place(one) + " = " + value);
      case kGlobal:
      case kLocal:
        return line((one.kind == kGlobal ? "global " : "local ") + one.target + (value.empty() ? "" : " = " + value));
      case kIf:
        return print_if(one);
      case kWhile:
        line("while " + value + ":");
        print_body(one.body);
        return line("end");
      case kBreak:
        return line("break");
      case kContinue:
        return line("continue");
      case kReturn:
        return line(value.empty() ? "return" : "return " + value);
      case kKill:
        return line("kill " + value);
      case kJoin:
        return line("join " + value);
      case kHalt:
        return line("halt");
      case kNothing:
        return line("pass");
    }
  }

  void print_if(const Statement& first) {
    std::string_view word = "if ";
    for (const Statement* one = &first; one != nullptr; word = "elif ") {
      line(std::string(word) + text(*one->value) + ":");
      print_body(one->body);
      const bool goes_on = one->otherwise.size() == 1 && one->otherwise[0].kind == Statement::Kind::kIf;
      if (!goes_on && !one->otherwise.empty()) {
        line("else:");
        print_body(one->otherwise);
      }
      one = goes_on ? &one->otherwise[0] : nullptr;
    }
    line("end");
  }

  /// As the parser has them: what binds more has a higher one.
  static int level(const Expression& one) {
    if (one.kind == Kind::kNot) return 3;
    if (one.kind == Kind::kNegate) return 7;
    if (one.kind != Kind::kOperator) return 8;
    if (one.op == Operator::kOr || one.op == Operator::kXor) return 1;
    if (one.op == Operator::kAnd) return 2;
    if (one.op >= Operator::kEqual) return 4;
    return one.op <= Operator::kSubtract ? 5 : 6;
  }
  /// In brackets if it binds less.
  static std::string text(const Expression& one, int least) {
    return level(one) < least ? "(" + text(one) + ")" : text(one);
  }

  static std::string place(const Statement& one) {
    std::string out = one.target;
    if (one.indices.empty()) return out;
    for (std::size_t i = 0; i < one.indices.size(); ++i) out += (i == 0 ? "[" : ", ") + text(*one.indices[i]);
    return out + "]";
  }

  static std::string list(const std::vector<ExpressionPtr>& parts, std::size_t from = 0) {
    std::string out;
    for (std::size_t i = from; i < parts.size(); ++i) out += (i == from ? "" : ", ") + text(*parts[i]);
    return out;
  }

  static std::string text(const Expression& one) {
    switch (one.kind) {
      case Kind::kConstant:
        return literal(one.value);
      case Kind::kName:
        return one.name;
      case Kind::kList:
        return "[" + list(one.parts) + "]";
      case Kind::kPose:
        return "p[" + list(one.parts) + "]";
      case Kind::kIndex: {
        return text(*one.parts[0], 8) + "[" + list(one.parts, 1) + "]";
      }
      case Kind::kCall:
      case Kind::kRun:
        return call(one);
      case Kind::kNegate:
        return "-" + text(*one.parts[0], 7);
      case Kind::kNot:
        return "not " + text(*one.parts[0], 3);
      case Kind::kOperator:
        return fmt::format("{} {} {}", text(*one.parts[0], level(one)), name_of(one.op),
                           text(*one.parts[1], level(one) + 1));
    }
    return {};
  }

  static std::string call(const Expression& one) {
    std::string arguments;
    for (const Argument& argument : one.arguments) {
      if (!arguments.empty()) arguments += ", ";
      if (!argument.name.empty()) arguments += argument.name + "=";
      arguments += text(*argument.value);
    }
    return fmt::format("{}{}({})", one.kind == Kind::kRun ? "run " : "", one.name, arguments);
  }

  static std::string literal(const Value& value) {
    if (const auto* real = value.get<double>()) {
      std::string digits = fmt::format("{:.17g}", *real);
      if (digits.find_first_of(".en") == std::string::npos) digits += ".0";
      return digits;
    }
    if (const auto* string = value.get<std::string>()) {
      const char quote = string->find('"') == std::string::npos ? '"' : '\'';
      return quote + *string + quote;
    }
    if (const auto* parts = value.get<List>()) {
      std::string out;
      for (const Value& part : *parts) out += (out.empty() ? "" : ", ") + literal(part);
      return "[" + out + "]";
    }
    if (const auto* pose = value.get<Pose>()) {
      std::string out;
      for (const double part : *pose) out += (out.empty() ? "" : ", ") + literal(part);
      return "p[" + out + "]";
    }
    return value.text();
  }

  std::string out_;
  std::size_t depth_ = 0;
};

}  // namespace

std::string print(const Script& script) { return Printer().print(script); }

}  // namespace takt::languages::urscript
