// From the text of an expression to its tree.
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "core/program/language/expression.h"

namespace takt::program {
namespace {

/// Longer texts and deeper trees are refused: evaluation is recursive.
constexpr std::size_t kMostCharacters = 1000;
constexpr int kMostDepth = 50;

struct ScaledUnit {
  std::string_view name, base;
  double factor;
};

/// Units beyond those of ports.
constexpr std::array<ScaledUnit, 7> kScaledUnits{{{"mm", "m", 1e-3},
                                                  {"cm", "m", 1e-2},
                                                  {"deg", "rad", std::numbers::pi / 180.0},
                                                  {"deg/s", "rad/s", std::numbers::pi / 180.0},
                                                  {"mm/s", "m/s", 1e-3},
                                                  {"ms", "s", 1e-3},
                                                  {"g", "kg", 1e-3}}};

/// What ends the reading of a text.
struct SyntaxError {
  std::size_t at;
  std::string message, hint;
};

using Node = ExpressionNode;

/// Recursive descent, lowest precedence first.
class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Node whole() {
    Node node = either();
    blanks();
    if (at_ < text_.size()) fail(fmt::format("'{}' is not expected", text_.substr(at_, 8)), "an operator or the end");
    return node;
  }

 private:
  [[noreturn]] void fail(std::string message, std::string hint = {}) const {
    throw SyntaxError{at_, std::move(message), std::move(hint)};
  }

  void blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  [[nodiscard]] char peek() {
    blanks();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(std::string_view token) {
    blanks();
    if (!text_.substr(at_).starts_with(token)) return false;
    at_ += token.size();
    return true;
  }
  void want(std::string_view token) {
    if (!take(token)) fail(fmt::format("'{}' is missing", token), fmt::format("a '{}' here", token));
  }
  [[nodiscard]] static bool letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
  [[nodiscard]] static bool digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

  /// A word by itself: "or" in "or x", not in "order".
  bool take_word(std::string_view word) {
    const std::size_t before = at_;
    if (!take(word)) return false;
    if (at_ >= text_.size() || (!letter(text_[at_]) && !digit(text_[at_]))) return true;
    at_ = before;
    return false;
  }

  static Node binary(std::string_view name, std::size_t at, Node left, Node right) {
    Node node{.kind = Node::Kind::kBinary, .name = std::string(name), .value = {}, .children = {}, .at = at};
    node.children.push_back(std::move(left));
    node.children.push_back(std::move(right));
    return node;
  }

  Node either() {
    const Depth depth(*this);
    Node left = both();
    while (take_word("or")) {
      const std::size_t at = at_ - 2;
      left = binary("or", at, std::move(left), both());
    }
    return left;
  }
  Node both() {
    Node left = negation();
    while (take_word("and")) {
      const std::size_t at = at_ - 3;
      left = binary("and", at, std::move(left), negation());
    }
    return left;
  }
  Node negation() {
    blanks();
    const std::size_t at = at_;
    if (!take_word("not")) return comparison();
    const Depth depth(*this);
    Node node{.kind = Node::Kind::kNot, .name = "not", .value = {}, .children = {}, .at = at};
    node.children.push_back(negation());
    return node;
  }
  Node comparison() {
    Node left = sum();
    for (const char* name : {"<=", ">=", "==", "!=", "<", ">"}) {
      blanks();
      const std::size_t at = at_;
      if (take(name)) return binary(name, at, std::move(left), sum());
    }
    return left;
  }
  Node sum() {
    Node left = product();
    for (;;) {
      const char c = peek();
      if (c != '+' && c != '-') return left;
      const std::size_t at = at_++;
      left = binary(std::string_view(&c, 1), at, std::move(left), product());
    }
  }
  Node product() {
    Node left = factor();
    for (;;) {
      const char c = peek();
      if (c != '*' && c != '/' && c != '%') return left;
      const std::size_t at = at_++;
      left = binary(std::string_view(&c, 1), at, std::move(left), factor());
    }
  }
  Node factor() {
    if (peek() != '-') return indexed();
    const Depth depth(*this);
    Node node{.kind = Node::Kind::kNegate, .name = "-", .value = {}, .children = {}, .at = at_++};
    node.children.push_back(factor());
    return node;
  }
  Node indexed() {
    Node node = primary();
    while (peek() == '[') {
      Node index{.kind = Node::Kind::kIndex, .name = "[]", .value = {}, .children = {}, .at = at_++};
      index.children.push_back(std::move(node));
      index.children.push_back(either());
      want("]");
      node = std::move(index);
    }
    return node;
  }

  Node primary() {
    const char c = peek();
    if (c == '(') return in_brackets();
    if (c == '[') return list();
    if (c == '\'') return quoted();
    if (digit(c) || c == '.') return number();
    if (letter(c)) return word();
    fail(c == '\0' ? "the text ends where a value is expected" : fmt::format("'{}' begins no value", c),
         "a number, a variable, a function, 'text', (...) or [...]");
  }
  Node in_brackets() {
    want("(");
    Node inside = either();
    want(")");
    return inside;
  }
  std::vector<Node> until(std::string_view end) {
    std::vector<Node> nodes;
    if (take(end)) return nodes;
    do nodes.push_back(either());
    while (take(","));
    want(end);
    return nodes;
  }
  Node list() {
    Node node{.kind = Node::Kind::kList, .name = "[]", .value = {}, .children = {}, .at = at_++};
    node.children = until("]");
    return node;
  }
  Node constant(std::size_t at, Value value) const {
    return {.kind = Node::Kind::kConstant, .name = {}, .value = std::move(value), .children = {}, .at = at};
  }
  Node quoted() {
    const std::size_t at = at_++;
    const std::size_t end = text_.find('\'', at_);
    if (end == std::string_view::npos) fail("the text has no end", "a second '");
    Node node = constant(at, Value::of(std::string(text_.substr(at_, end - at_))));
    at_ = end + 1;
    return node;
  }
  Node number() {
    const std::size_t at = at_;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value))
      fail("this is not a number", "digits, a point, an exponent: 0.25, 1e-3");
    at_ = static_cast<std::size_t>(end - text_.data());
    // The unit follows at once: 0.25[m/s].
    if (at_ < text_.size() && text_[at_] == '[') return with_unit(at, value);
    return constant(at, Value::of(value));
  }
  Node with_unit(std::size_t at, double value) {
    const std::size_t begin = at_ + 1;
    const std::size_t end = text_.find(']', begin);
    if (end == std::string_view::npos) fail("the unit has no end", "0.25[m/s]");
    std::string_view unit = text_.substr(begin, end - begin);
    for (const ScaledUnit& scaled : kScaledUnits) {
      if (unit != scaled.name) continue;
      value *= scaled.factor;
      unit = scaled.base;
      break;
    }
    const auto terms = net::parse_unit(unit);
    if (!terms || terms->size() != 1 || !terms->front().variables.empty()) {
      fail(fmt::format("'{}' is not a unit", unit),
           "m, mm, s, ms, rad, deg, kg, g, N, Nm, V, ... and products of them");
    }
    at_ = end + 1;
    return constant(at, Value::of(value, terms->front().dimension));
  }
  Node word() {
    const std::size_t at = at_;
    while (at_ < text_.size() && (letter(text_[at_]) || digit(text_[at_]))) ++at_;
    const std::string name(text_.substr(at, at_ - at));
    if (name == "true" || name == "false") return constant(at, Value::of(name == "true"));
    if (name == "null") return constant(at, Value::unknown({}));
    if (peek() != '(') {
      return {.kind = Node::Kind::kVariable, .name = name, .value = {}, .children = {}, .at = at};
    }
    ++at_;
    Node node{.kind = Node::Kind::kCall, .name = name, .value = {}, .children = {}, .at = at};
    node.children = until(")");
    return node;
  }

  struct Depth {
    explicit Depth(Parser& parser) : parser_(parser) {
      if (++parser_.depth_ > kMostDepth) parser_.fail("this is nested too deeply", "variables for parts of it");
    }
    ~Depth() { --parser_.depth_; }
    Depth(const Depth&) = delete;
    Depth& operator=(const Depth&) = delete;
    Parser& parser_;
  };

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Result<Expression> Expression::parse(std::string_view text) {
  if (text.size() > kMostCharacters) {
    return failure(Code::kTooLarge, {}, fmt::format("an expression of {} characters", text.size()), "Use at most 1000");
  }
  try {
    Expression expression;
    expression.text_ = text;
    expression.root_ = std::make_shared<const ExpressionNode>(Parser(text).whole());
    return expression;
  } catch (const SyntaxError& error) {
    return failure(Code::kSyntax, {}, fmt::format("in '{}', character {}: {}", text, error.at + 1, error.message),
                   error.hint);
  }
}

bool is_expression(std::string_view text) { return text.starts_with('$') && !text.starts_with("$$"); }

}  // namespace takt::program
