#include "languages/behavior_tree/script.h"

#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace takt::languages {

/// A tree of an expression. Operators by their text; leaves "number", "text", "name".
struct TreeScript::Node {
  std::string kind;
  TreeValue value = {};
  std::string name = {};
  std::vector<std::shared_ptr<const Node>> inputs = {};
};

namespace {

using ScriptNode = TreeScript::Node;
using NodePtr = std::shared_ptr<const ScriptNode>;

constexpr int kDeepest = 64;
constexpr std::size_t kLongest = 8192;

std::unexpected<Diagnostics> script_error(Code code, std::string message, std::string hint = {}) {
  return failure(code, {}, std::move(message), std::move(hint));
}

bool is_name_begin(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '@'; }
bool is_name_part(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '@';
}

struct ScriptToken {
  enum class Kind { kNumber, kText, kName, kOperator, kEnd } kind = Kind::kEnd;
  std::string text;
  double number = 0.0;
  std::size_t at = 0;
};

Result<std::vector<ScriptToken>> tokens_of(std::string_view text) {
  static constexpr std::array<std::string_view, 29> kOperators = {
      ":=", "==", "!=", "<=", ">=", "&&", "||", "+=", "-=", "*=", "/=", "..", "=", "<", ">",
      "+",  "-",  "*",  "/",  "!",  "~",  "&",  "|",  "^",  "?",  ":",  "(",  ")", ";"};
  std::vector<ScriptToken> tokens;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (std::isspace(static_cast<unsigned char>(c)) != 0) {
      ++i;
    } else if (std::isdigit(static_cast<unsigned char>(c)) != 0) {
      ScriptToken token{.kind = ScriptToken::Kind::kNumber, .text = {}, .at = i};
      const char *begin = text.data() + i, *end = text.data() + text.size();
      if (text.substr(i).starts_with("0x") || text.substr(i).starts_with("0X")) {
        long long whole = 0;
        const auto [stop, error] = std::from_chars(begin + 2, end, whole, 16);
        if (error != std::errc()) return script_error(Code::kSyntax, fmt::format("no number at {}", i + 1));
        token.number = static_cast<double>(whole);
        i += static_cast<std::size_t>(stop - begin);
      } else {
        const auto [stop, error] = std::from_chars(begin, end, token.number);
        if (error != std::errc()) return script_error(Code::kSyntax, fmt::format("no number at {}", i + 1));
        i += static_cast<std::size_t>(stop - begin);
        if (i >= 2 && text[i - 1] == '.' && i < text.size() && text[i] == '.') --i;  // "1..x" joins
      }
      if (i < text.size() && is_name_begin(text[i]))
        return script_error(Code::kSyntax, fmt::format("a name begins inside of a number at {}", i + 1));
      tokens.push_back(std::move(token));
    } else if (c == '\'') {
      const std::size_t end = text.find('\'', i + 1);
      if (end == std::string_view::npos)
        return script_error(Code::kSyntax, fmt::format("a text that begins at {} does not end", i + 1), "Add a '");
      tokens.push_back({ScriptToken::Kind::kText, std::string(text.substr(i + 1, end - i - 1)), 0.0, i});
      i = end + 1;
    } else if (is_name_begin(c)) {
      std::size_t end = i + 1;
      while (end < text.size() && is_name_part(text[end]) && !text.substr(end).starts_with("..")) ++end;
      tokens.push_back({ScriptToken::Kind::kName, std::string(text.substr(i, end - i)), 0.0, i});
      i = end;
    } else {
      std::string_view found;
      for (const std::string_view one : kOperators)
        if (text.substr(i).starts_with(one) && found.empty()) found = one;
      if (found.empty())
        return script_error(Code::kSyntax, fmt::format("unexpected '{}' at {}", c, i + 1),
                            "Use names, numbers, 'texts' and operators");
      tokens.push_back({ScriptToken::Kind::kOperator, std::string(found), 0.0, i});
      i += found.size();
    }
  }
  tokens.push_back({ScriptToken::Kind::kEnd, "the end", 0.0, text.size()});
  return tokens;
}

class ScriptParser {
 public:
  explicit ScriptParser(std::vector<ScriptToken> tokens) : tokens_(std::move(tokens)) {}

  Result<std::vector<NodePtr>> statements() {
    std::vector<NodePtr> all;
    while (!wrong_ && !is_end()) {
      if (take(";")) continue;
      all.push_back(statement());
      if (!wrong_ && !is_end() && !take(";")) refuse("an operator or ';'");
    }
    if (wrong_) return script_error(Code::kSyntax, *wrong_, "Correct the script");
    return all;
  }

 private:
  [[nodiscard]] const ScriptToken& next() const { return tokens_[at_]; }
  [[nodiscard]] bool is_end() const { return next().kind == ScriptToken::Kind::kEnd; }
  [[nodiscard]] bool is(std::string_view text) const {
    return next().kind == ScriptToken::Kind::kOperator && next().text == text;
  }
  bool take(std::string_view text) {
    if (!is(text)) return false;
    ++at_;
    return true;
  }
  NodePtr refuse(std::string_view wanted) {
    if (!wrong_) wrong_ = fmt::format("unexpected {} at {}, instead of {}", next().text, next().at + 1, wanted);
    return std::make_shared<const ScriptNode>(ScriptNode{.kind = "number", .value = {0.0}});
  }
  static NodePtr apply(std::string kind, std::vector<NodePtr> inputs) {
    return std::make_shared<const ScriptNode>(ScriptNode{.kind = std::move(kind), .inputs = std::move(inputs)});
  }

  NodePtr statement() {
    static constexpr std::array<std::string_view, 6> kAssignments = {":=", "=", "+=", "-=", "*=", "/="};
    if (next().kind == ScriptToken::Kind::kName) {
      for (const std::string_view one : kAssignments) {
        const ScriptToken& after = tokens_[at_ + 1];
        if (after.kind != ScriptToken::Kind::kOperator || after.text != one) continue;
        ScriptNode node{.kind = std::string(one), .name = next().text};
        at_ += 2;
        node.inputs.push_back(choice());
        return std::make_shared<const ScriptNode>(std::move(node));
      }
    }
    return choice();
  }

  NodePtr choice() {
    if (++depth_ > kDeepest) {
      wrong_ = fmt::format("nested deeper than {}", kDeepest);
      --depth_;
      return refuse("less");
    }
    NodePtr condition = binary(0);
    if (take("?")) {
      NodePtr yes = choice();
      if (!take(":")) refuse("':'");
      condition = apply("?", {condition, yes, choice()});
    }
    --depth_;
    return condition;
  }

  /// Operators from the weakest to the strongest.
  NodePtr binary(std::size_t level) {
    static const std::vector<std::vector<std::string_view>> kLevels = {
        {"||"}, {"&&"}, {"==", "!=", "<", "<=", ">", ">="}, {".."}, {"|", "^"}, {"&"}, {"+", "-"}, {"*", "/"}};
    if (level == kLevels.size()) return unary();
    NodePtr left = binary(level + 1);
    for (bool found = true; found && !wrong_;) {
      found = false;
      for (const std::string_view one : kLevels[level]) {
        if (!take(one)) continue;
        left = apply(std::string(one), {left, binary(level + 1)});
        found = true;
        break;
      }
    }
    return left;
  }

  NodePtr unary() {
    for (const std::string_view one : {"!", "-", "~"}) {
      if (!take(one)) continue;
      if (++depth_ > kDeepest) return refuse("less");
      NodePtr inner = unary();
      --depth_;
      return apply(std::string("unary ") + std::string(one), {inner});
    }
    return primary();
  }

  NodePtr primary() {
    const ScriptToken token = next();
    if (take("(")) {
      NodePtr inside = choice();
      if (!take(")")) refuse("')'");
      return inside;
    }
    switch (token.kind) {
      case ScriptToken::Kind::kNumber:
        ++at_;
        return std::make_shared<const ScriptNode>(ScriptNode{.kind = "number", .value = {token.number}});
      case ScriptToken::Kind::kText:
        ++at_;
        return std::make_shared<const ScriptNode>(ScriptNode{.kind = "text", .value = {token.text}});
      case ScriptToken::Kind::kName:
        ++at_;
        if (token.text == "true" || token.text == "false")
          return std::make_shared<const ScriptNode>(
              ScriptNode{.kind = "number", .value = {token.text == "true" ? 1.0 : 0.0}});
        return std::make_shared<const ScriptNode>(ScriptNode{.kind = "name", .name = token.text});
      default:
        return refuse("a value");
    }
  }

  std::vector<ScriptToken> tokens_;
  std::size_t at_ = 0;
  int depth_ = 0;
  std::optional<std::string> wrong_;
};

// -- Evaluation -------------------------------------------------------------------------------------------------------

Result<TreeValue> evaluate(const ScriptNode& node, TreeVariables& variables);

Result<TreeValue> wrong_types(const std::string& kind, const TreeValue& a, const TreeValue& b) {
  return script_error(Code::kWrongType, fmt::format("'{}' {} '{}'", a.to_text(), kind, b.to_text()),
                      "Give both sides the same type");
}

Result<TreeValue> compare(const std::string& kind, const TreeValue& a, const TreeValue& b) {
  if (a.is_number() != b.is_number()) return wrong_types(kind, a, b);
  const auto order = a.is_number() ? (a.number() < b.number()   ? -1
                                      : a.number() > b.number() ? 1
                                                                : 0)
                                   : a.text().compare(b.text());
  const bool holds = kind == "=="   ? order == 0
                     : kind == "!=" ? order != 0
                     : kind == "<"  ? order < 0
                     : kind == "<=" ? order <= 0
                     : kind == ">"  ? order > 0
                                    : order >= 0;
  return TreeValue{holds ? 1.0 : 0.0};
}

Result<TreeValue> calculate(const std::string& kind, const TreeValue& a, const TreeValue& b) {
  if (kind == "+" && !a.is_number() && !b.is_number()) return TreeValue{a.text() + b.text()};
  if (!a.is_number() || !b.is_number()) return wrong_types(kind, a, b);
  const double x = a.number(), y = b.number();
  if (kind == "+") return TreeValue{x + y};
  if (kind == "-") return TreeValue{x - y};
  if (kind == "*") return TreeValue{x * y};
  if (kind == "/") return TreeValue{x / y};
  constexpr double kLargest = 9007199254740992.0;
  if (std::trunc(x) != x || std::trunc(y) != y || std::abs(x) > kLargest || std::abs(y) > kLargest)
    return script_error(Code::kWrongType, fmt::format("'{}' of {} and {}", kind, x, y), "Give whole numbers");
  const auto i = static_cast<std::int64_t>(x), j = static_cast<std::int64_t>(y);
  return TreeValue{static_cast<double>(kind == "&" ? i & j : kind == "|" ? i | j : i ^ j)};
}

Result<TreeValue> assign(const ScriptNode& node, TreeVariables& variables) {
  auto value = evaluate(*node.inputs.front(), variables);
  if (!value) return value;
  const TreeValue* known = variables.find(node.name);
  const bool has = known != nullptr && known->is_set();
  if (node.kind != ":=" && !has)
    return script_error(Code::kUnknownName, fmt::format("there is no entry '{}'", node.name),
                        fmt::format("Declare it by '{} := ...'", node.name));
  if (has && known->is_number() != value->is_number())
    return script_error(Code::kWrongType,
                        fmt::format("'{}' is a {}", node.name, known->is_number() ? "number" : "text"),
                        "Keep the type of an entry");
  if (node.kind.size() == 2 && node.kind != ":=") {
    value = calculate(node.kind.substr(0, 1), *known, *value);
    if (!value) return value;
  }
  variables.set(node.name, *value);
  return value;
}

Result<TreeValue> evaluate(const ScriptNode& node, TreeVariables& variables) {
  if (node.kind == "number" || node.kind == "text") return node.value;
  if (node.kind == "name") {
    const TreeValue* found = variables.find(node.name);
    if (found != nullptr && found->is_set()) return *found;
    return script_error(Code::kUnknownName, fmt::format("there is no entry '{}'", node.name),
                        "Set it before it is used");
  }
  if (!node.name.empty()) return assign(node, variables);
  const auto a = evaluate(*node.inputs[0], variables);
  if (!a) return a;
  const auto truth = truth_of(*a);
  if (node.kind == "&&" || node.kind == "||" || node.kind == "?" || node.kind == "unary !") {
    if (!truth) return wrong_types(node.kind, *a, TreeValue{1.0});
    if (node.kind == "unary !") return TreeValue{*truth ? 0.0 : 1.0};
    if (node.kind == "?") return evaluate(*node.inputs[*truth ? 1 : 2], variables);
    if (*truth == (node.kind == "||")) return TreeValue{*truth ? 1.0 : 0.0};
    const auto b = evaluate(*node.inputs[1], variables);
    if (!b) return b;
    const auto second = truth_of(*b);
    if (!second) return wrong_types(node.kind, *a, *b);
    return TreeValue{*second ? 1.0 : 0.0};
  }
  if (node.kind == "unary -")
    return a->is_number() ? Result<TreeValue>(TreeValue{-a->number()}) : wrong_types("-", *a, *a);
  if (node.kind == "unary ~") return calculate("^", *a, TreeValue{-1.0});
  const auto b = evaluate(*node.inputs[1], variables);
  if (!b) return b;
  if (node.kind == "..") return TreeValue{a->to_text() + b->to_text()};
  static constexpr std::array<std::string_view, 6> kComparisons = {"==", "!=", "<", "<=", ">", ">="};
  for (const std::string_view one : kComparisons)
    if (node.kind == one) return compare(node.kind, *a, *b);
  return calculate(node.kind, *a, *b);
}

}  // namespace

std::string TreeValue::to_text() const {
  if (!is_set()) return "";
  return is_number() ? fmt::format("{}", number()) : text();
}

TreeValue TreeValue::of_text(std::string_view text) {
  if (text == "true" || text == "false") return {text == "true" ? 1.0 : 0.0};
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (!text.empty() && error == std::errc() && end == text.data() + text.size() && std::isfinite(number))
    return {number};
  return {std::string(text)};
}

std::optional<bool> truth_of(const TreeValue& value) {
  return value.is_number() ? std::optional(value.number() != 0.0) : std::nullopt;
}

Result<TreeScript> TreeScript::parse(std::string_view text) {
  if (text.size() > kLongest)
    return script_error(Code::kTooLarge, fmt::format("a script of {} characters", text.size()),
                        fmt::format("Write {} at most", kLongest));
  auto tokens = tokens_of(text);
  if (!tokens) return std::unexpected(std::move(tokens.error()));
  auto statements = ScriptParser(std::move(*tokens)).statements();
  if (!statements) return std::unexpected(std::move(statements.error()));
  TreeScript script;
  script.statements_ = std::move(*statements);
  return script;
}

Result<TreeValue> TreeScript::run(TreeVariables& variables) const {
  TreeValue last{1.0};
  for (const auto& one : statements_) {
    auto value = evaluate(*one, variables);
    if (!value) return value;
    last = std::move(*value);
  }
  return last;
}

}  // namespace takt::languages
