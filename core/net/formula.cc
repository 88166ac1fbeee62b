#include "core/net/formula.h"

#include <array>
#include <cctype>
#include <charconv>

namespace takt::net {
namespace {

using Kind = Formula::Step::Kind;

/// Recursive descent; formulas are written by programmers, a line each.
class Parser {
 public:
  Parser(std::string_view text, const PrimitiveInfo& info) : rest_(text), info_(info) {}

  std::optional<Formula> run() {
    if (!binary(0) || !blank_to_end()) return std::nullopt;
    return std::move(formula_);
  }

 private:
  struct Operator {
    std::string_view text;
    Kind kind;
  };
  static constexpr std::array<Operator, 4> kOperators = {
      {{"??", Kind::kElse}, {"|", Kind::kOr}, {"^", Kind::kXor}, {"&", Kind::kAnd}}};

  void skip_blanks() {
    while (!rest_.empty() && rest_.front() == ' ') rest_.remove_prefix(1);
  }
  bool blank_to_end() {
    skip_blanks();
    return rest_.empty();
  }
  bool take(std::string_view token) {
    skip_blanks();
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }
  std::string_view word() {
    skip_blanks();
    std::size_t size = 0;
    while (size < rest_.size() && (std::isalnum(static_cast<unsigned char>(rest_[size])) != 0 || rest_[size] == '_')) {
      ++size;
    }
    const std::string_view found = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return found;
  }
  void push(const Formula::Step& step) { formula_.steps.push_back(step); }

  bool binary(std::size_t level) {
    if (level == kOperators.size()) return unary();
    if (!binary(level + 1)) return false;
    while (take(kOperators[level].text)) {
      if (!binary(level + 1)) return false;
      push({.kind = kOperators[level].kind, .a = {}, .b = {}});
    }
    return true;
  }

  bool unary() {
    if (take("!")) {
      if (!unary()) return false;
      push({.kind = Kind::kNot, .a = {}, .b = {}});
      return true;
    }
    if (take("(")) return binary(0) && take(")");
    if (take("?")) {
      push({.kind = Kind::kUnknown, .a = {}, .b = {}});
      return true;
    }
    return named();
  }

  /// A constant, null(x), a Boolean input or a comparison.
  bool named() {
    const std::string_view before = rest_;
    const std::string_view name = word();
    if (name == "true" || name == "false") {
      push({.kind = Kind::kConstant, .constant = name == "true", .a = {}, .b = {}});
      return true;
    }
    if (name == "null" && take("(")) {
      const int input = input_named(word());
      push({.kind = Kind::kIsNull, .input = input, .a = {}, .b = {}});
      return input >= 0 && take(")");
    }
    const int input = input_named(name);
    if (input >= 0 && type_of(input) == ValueType::kBoolean) {
      push({.kind = Kind::kInput, .input = input, .a = {}, .b = {}});
      return true;
    }
    rest_ = before;
    return comparison();
  }

  bool comparison() {
    Formula::Step step{.a = {}, .b = {}};
    if (!number(step.a)) return false;
    if (take("<=")) {
      step.kind = Kind::kLessEqual;
    } else if (take("<")) {
      step.kind = Kind::kLess;
    } else if (take("=")) {
      step.kind = Kind::kEqual;
    } else {
      return false;
    }
    push(step);
    return number(formula_.steps.back().b);
  }

  bool number(FormulaNumber& found) {
    skip_blanks();
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), found.literal);
    if (error == std::errc()) {
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      return true;
    }
    found.input = input_named(word());
    return found.input >= 0 &&
           (type_of(found.input) == ValueType::kReal || type_of(found.input) == ValueType::kInteger);
  }

  [[nodiscard]] int input_named(std::string_view name) const {
    for (std::size_t i = 0; i < info_.inputs.size(); ++i) {
      if (info_.inputs[i].name == name) return static_cast<int>(i);
    }
    return -1;
  }
  [[nodiscard]] ValueType type_of(int input) const { return info_.inputs[static_cast<std::size_t>(input)].type; }

  std::string_view rest_;
  const PrimitiveInfo& info_;
  Formula formula_;
};

}  // namespace

std::optional<Formula> parse_formula(std::string_view text, const PrimitiveInfo& info) {
  return Parser(text, info).run();
}

}  // namespace takt::net
