// Newlines count little: an expression may begin on the next line, and a statement ends where its expression ends. A
// bracket or an operator at the beginning of a line does not go on with what stands before, unless a bracket is open.
#include <algorithm>
#include <array>
#include <tuple>

#include <fmt/format.h>

#include "languages/urscript/syntax.h"

namespace takt::languages::urscript {

namespace {

constexpr int kDeepest = 100;  // of what is nested: more than anybody writes, less than the stack holds

constexpr std::array<std::string_view, 26> kKeywords = {
    "def",    "sec",    "thread", "end", "if",   "elif", "else",           "while",         "break", "continue",
    "return", "global", "local",  "run", "kill", "join", "enter_critical", "exit_critical", "halt",  "pass",
    "True",   "False",  "and",    "or",  "not",  "xor"};

bool is_keyword(std::string_view word) { return std::ranges::find(kKeywords, word) != kKeywords.end(); }

struct Precedence {
  std::string_view sign;
  int level;
  Operator op;
};
constexpr std::array<Precedence, 15> kOperators = {{{"or", 1, Operator::kOr},
                                                    {"xor", 1, Operator::kXor},
                                                    {"and", 2, Operator::kAnd},
                                                    {"==", 4, Operator::kEqual},
                                                    {"!=", 4, Operator::kNotEqual},
                                                    {"<", 4, Operator::kLess},
                                                    {">", 4, Operator::kGreater},
                                                    {"<=", 4, Operator::kLessEqual},
                                                    {">=", 4, Operator::kGreaterEqual},
                                                    {"+", 5, Operator::kAdd},
                                                    {"-", 5, Operator::kSubtract},
                                                    {"*", 6, Operator::kMultiply},
                                                    {"/", 6, Operator::kDivide},
                                                    {"%", 6, Operator::kModulo},
                                                    {"", 0, Operator::kAdd}}};
constexpr int kNotLevel = 3, kHighest = 6;

/// Thrown inside of the parser only.
struct Refused {
  ScriptError error;
  bool final = false;  ///< nothing behind it can be read
};

class Parser {
 public:
  Parser(std::vector<Token> tokens, Script& script, ScriptErrors& errors)
      : tokens_(std::move(tokens)), script_(script), errors_(errors) {}

  void run() {
    try {
      parse_script();
    } catch (Refused& refused) {
      errors_.push_back(std::move(refused.error));
    }
  }

 private:
  using Kind = Expression::Kind;

  void parse_script() {
    script_.name = "unnamed";
    script_.bare = !here().is("def") && !here().is("sec");
    if (script_.bare) return parse_block(script_.body, {});
    script_.secondary = here().is("sec");
    Function main = parse_function();
    // What follows the program is part of it as well: definitions, or statements at its end.
    script_.name = main.name;
    script_.body = std::move(main.body);
    parse_block(script_.body, {});
  }

  [[nodiscard]] const Token& here() const { return tokens_[at_]; }
  [[nodiscard]] bool at_end() const { return here().kind == Token::Kind::kEnd; }
  /// Not the end of the script: nothing accepts it.
  const Token& take() { return tokens_[at_++]; }
  bool accept(std::string_view word) {
    if (!here().is(word)) return false;
    (void)take();
    return true;
  }
  void expect(std::string_view word) {
    if (!accept(word)) refuse(fmt::format("expected '{}'{}", word, found()));
  }
  [[nodiscard]] std::string found() const {
    if (at_end()) return ", the script ends";
    return fmt::format(", found '{}'", here().text.substr(0, 40));
  }
  [[noreturn]] void refuse(std::string text) const { throw Refused{{here().line, here().column, std::move(text)}}; }
  /// Writes an error down and goes on with the next line.
  void recover(Refused& refused, std::size_t from) {
    if (refused.final || at_end() || errors_.size() + 1 >= kMostErrors) throw std::move(refused);
    errors_.push_back(std::move(refused.error));
    brackets_ = 0;
    if (at_ == from) (void)take();
    while (!at_end() && !here().begins_line) (void)take();
  }
  /// The rest of the line that begins a block, with its colon.
  template <class Rest>
  void parse_head(Rest rest) {
    const std::size_t from = at_;
    try {
      rest();
      expect(":");
    } catch (Refused& refused) {
      recover(refused, from);
    }
  }
  std::string take_name() {
    if (here().kind != Token::Kind::kName || is_keyword(here().text)) refuse("expected a name" + found());
    return take().text;
  }

  /// One level deeper while it lives.
  class Level {
   public:
    explicit Level(Parser& parser) : parser_(parser) {
      if (++parser_.depth_ <= kDeepest) return;
      const Token& here = parser_.here();
      throw Refused{{here.line, here.column, "nested too deeply"}, true};
    }
    ~Level() { --parser_.depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

   private:
    Parser& parser_;
  };

  // -- Statements ----------------------------------------------------------------------------------------------------
  /// Up to one of the words, which is not taken; without words to the end of the script.
  void parse_block(Block& block, std::initializer_list<std::string_view> until) {
    const Level level(*this);
    for (;;) {
      while (accept(";")) continue;
      for (const std::string_view word : until)
        if (here().is(word)) return;
      if (at_end()) {
        if (until.size() == 0) return;
        refuse("expected 'end', the script ends");
      }
      parse_statement(block);
    }
  }

  Function parse_function() {
    Function function;
    function.is_thread = here().is("thread");
    function.line = here().line;
    function.column = here().column;
    (void)take();
    parse_head([&] {
      function.name = take_name();
      expect("(");
      while (!here().is(")")) {
        Parameter parameter{take_name(), {}};
        if (accept("=")) parameter.fallback = constant(*parse_expression());
        function.parameters.push_back(std::move(parameter));
        if (!accept(",")) break;
      }
      expect(")");
    });
    parse_block(function.body, {"end"});
    expect("end");
    return function;
  }

  void parse_statement(Block& block) {
    if (here().is("def") || here().is("thread") || here().is("sec")) {
      script_.functions.push_back(parse_function());
      return;
    }
    Statement statement;
    statement.line = here().line;
    statement.column = here().column;
    operators_ = 0;
    const std::size_t from = at_;
    try {
      if (!parse_keyword(statement)) parse_assignment(statement);
      block.push_back(std::move(statement));
    } catch (Refused& refused) {
      recover(refused, from);
    }
  }

  /// @return false if it begins with no keyword.
  bool parse_keyword(Statement& out) {
    using enum Statement::Kind;
    if (accept("if")) return parse_if(out), true;
    if (accept("while")) return parse_while(out), true;
    if (accept("return")) return parse_return(out), true;
    if (accept("global")) return parse_declaration(out, kGlobal), true;
    if (accept("local")) return parse_declaration(out, kLocal), true;
    if (accept("kill")) return parse_operand(out, kKill), true;
    if (accept("join")) return parse_operand(out, kJoin), true;
    static constexpr std::array<std::pair<std::string_view, Statement::Kind>, 6> kAlone = {
        {{"break", kBreak},
         {"continue", kContinue},
         {"halt", kHalt},
         {"pass", kNothing},
         {"enter_critical", kNothing},
         {"exit_critical", kNothing}}};
    for (const auto& [word, kind] : kAlone) {
      if (!accept(word)) continue;
      out.kind = kind;
      return true;
    }
    return false;
  }
  /// One that is wrong counts as True, so that the tree is whole.
  void parse_condition(Statement& out) {
    parse_head([&] { out.value = parse_expression(); });
    if (out.value == nullptr) out.value = parse_constant(Value(true));
  }
  void parse_if(Statement& first) {
    const Level level(*this);
    Statement* out = &first;
    for (int branches = 0; branches < kMostBranches; ++branches) {
      out->kind = Statement::Kind::kIf;
      parse_condition(*out);
      parse_block(out->body, {"elif", "else", "end"});
      if (!here().is("elif")) return parse_else(*out);
      Statement& next = out->otherwise.emplace_back();
      next.line = here().line;
      next.column = here().column;
      (void)take();
      out = &next;
    }
    refuse("too many branches of one 'if'");
  }
  void parse_else(Statement& out) {
    if (accept("else")) {
      expect(":");
      parse_block(out.otherwise, {"end"});
    }
    expect("end");
  }
  void parse_while(Statement& out) {
    out.kind = Statement::Kind::kWhile;
    parse_condition(out);
    parse_block(out.body, {"end"});
    expect("end");
  }
  void parse_return(Statement& out) {
    out.kind = Statement::Kind::kReturn;
    if (!here().begins_line && !at_end() && !here().is("end") && !here().is(";")) out.value = parse_expression();
  }
  void parse_declaration(Statement& out, Statement::Kind kind) {
    out.kind = kind;
    out.target = take_name();
    if (accept("=")) out.value = parse_expression();
  }
  void parse_operand(Statement& out, Statement::Kind kind) {
    out.kind = kind;
    out.value = parse_expression();
  }

  void parse_assignment(Statement& out) {
    ExpressionPtr first = parse_expression();
    if (!accept("=")) {
      out.kind = Statement::Kind::kExpression;
      out.value = std::move(first);
      return;
    }
    out.kind = Statement::Kind::kAssign;
    out.value = parse_expression();
    if (first->kind == Kind::kIndex && first->parts[0]->kind == Kind::kName) {
      out.target = first->parts[0]->name;
      out.indices.assign(std::make_move_iterator(first->parts.begin() + 1),
                         std::make_move_iterator(first->parts.end()));
    } else if (first->kind == Kind::kName) {
      out.target = first->name;
    } else {
      throw Refused{{first->line, first->column, "expected a variable before '='"}};
    }
  }

  // -- Expressions ---------------------------------------------------------------------------------------------------
  ExpressionPtr make(Kind kind) const {
    auto expression = std::make_unique<Expression>();
    expression->kind = kind;
    expression->line = here().line;
    expression->column = here().column;
    return expression;
  }
  /// Goes on with what stands before it.
  [[nodiscard]] bool continues() const { return !here().begins_line || brackets_ > 0; }

  ExpressionPtr parse_expression(int level = 1) {
    if (level == kNotLevel && here().is("not")) {
      const Level deeper(*this);
      auto expression = make(Kind::kNot);
      (void)take();
      expression->parts.push_back(parse_expression(kNotLevel));
      return expression;
    }
    if (level > kHighest) return parse_unary();
    ExpressionPtr left = parse_expression(level + 1);
    while (const Precedence* found_operator = operator_here(level)) {
      auto expression = make(Kind::kOperator);
      expression->op = found_operator->op;
      (void)take();
      expression->parts.push_back(std::move(left));
      expression->parts.push_back(parse_expression(level + 1));
      left = std::move(expression);
      count_operator();
    }
    return left;
  }
  /// They nest to the left, as deep as there are many.
  void count_operator() {
    if (++operators_ > kMostOperators) refuse("too many operators in one statement");
  }
  /// Also at the beginning of a line: no statement that does something begins with a sign.
  [[nodiscard]] const Precedence* operator_here(int level) const {
    for (const Precedence& row : kOperators)
      if (row.level == level && here().is(row.sign)) return &row;
    return nullptr;
  }

  ExpressionPtr parse_unary() {
    const Level deeper(*this);
    if (here().is("not")) return parse_expression(kNotLevel);
    if (accept("+")) return parse_unary();
    if (!here().is("-")) return parse_postfix();
    auto expression = make(Kind::kNegate);
    (void)take();
    expression->parts.push_back(parse_unary());
    return expression;
  }

  ExpressionPtr parse_postfix() {
    ExpressionPtr expression = parse_primary();
    while (here().is("[") && continues()) {
      auto indexed = make(Kind::kIndex);
      indexed->parts.push_back(std::move(expression));
      (void)take();
      parse_list("]", indexed->parts);
      if (indexed->parts.size() < 2) refuse("expected an index");
      expression = std::move(indexed);
      count_operator();
    }
    return expression;
  }

  ExpressionPtr parse_primary() {
    const Token& token = here();
    if (token.kind == Token::Kind::kNumber) return parse_constant(take().value);
    if (token.kind == Token::Kind::kString) return parse_constant(Value(take().text));
    if (accept("True")) return parse_constant(Value(true));
    if (accept("False")) return parse_constant(Value(false));
    if (accept("(")) return parse_brackets();
    if (token.is("[")) return parse_list_literal(Kind::kList);
    if (accept("run")) return parse_call(Kind::kRun);
    if (token.kind != Token::Kind::kName || is_keyword(token.text)) refuse("expected an expression" + found());
    if (token.is("p") && begins_pose()) {
      (void)take();
      return parse_list_literal(Kind::kPose);
    }
    if (tokens_[at_ + 1].is("(")) return parse_call(Kind::kCall);
    auto name = make(Kind::kName);
    name->name = take().text;
    return name;
  }
  ExpressionPtr parse_constant(Value value) const {
    auto expression = make(Kind::kConstant);
    expression->value = std::move(value);
    return expression;
  }
  ExpressionPtr parse_brackets() {
    ++brackets_;
    ExpressionPtr inner = parse_expression();
    --brackets_;
    expect(")");
    return inner;
  }
  void parse_list(std::string_view end, std::vector<ExpressionPtr>& parts) {
    ++brackets_;
    while (!here().is(end)) {
      parts.push_back(parse_expression());
      if (!accept(",")) break;
    }
    --brackets_;
    expect(end);
  }
  ExpressionPtr parse_list_literal(Kind kind) {
    auto list = make(kind);
    expect("[");
    parse_list("]", list->parts);
    if (kind == Kind::kPose && list->parts.size() != 6) refuse("expected six coordinates of a pose");
    return list;
  }
  /// `p` is also a variable in common use: a pose has five commas between its brackets.
  [[nodiscard]] bool begins_pose() const {
    if (!tokens_[at_ + 1].is("[")) return false;
    int depth = 0, commas = 0;
    for (std::size_t i = at_ + 1; i < tokens_.size(); ++i) {
      const Token& token = tokens_[i];
      if (token.is("[") || token.is("(")) ++depth;
      if (token.is(",") && depth == 1) ++commas;
      if ((token.is("]") || token.is(")")) && --depth == 0) break;
    }
    return commas == 5;
  }
  ExpressionPtr parse_call(Kind kind) {
    auto call = make(kind);
    call->name = take_name();
    expect("(");
    ++brackets_;
    while (!here().is(")")) {
      Argument argument;
      if (here().kind == Token::Kind::kName && tokens_[at_ + 1].is("=")) {
        argument.name = take().text;
        (void)take();
      }
      argument.value = parse_expression();
      call->arguments.push_back(std::move(argument));
      if (!accept(",")) break;
    }
    --brackets_;
    expect(")");
    return call;
  }

  /// Of a default: it is known before the program runs.
  Value constant(const Expression& expression) const {
    switch (expression.kind) {
      case Kind::kConstant:
        return expression.value;
      case Kind::kNegate:
        if (auto value = negated(constant(*expression.parts[0]))) return *value;
        break;
      case Kind::kList: {
        List list;
        for (const ExpressionPtr& part : expression.parts) list.push_back(constant(*part));
        return list;
      }
      case Kind::kPose: {
        Pose pose{};
        for (std::size_t i = 0; i < pose.size(); ++i) pose[i] = constant(*expression.parts[i]).number().value_or(0.0);
        return pose;
      }
      default:
        break;
    }
    throw Refused{{expression.line, expression.column, "expected a constant as default"}};
  }

  static constexpr int kMostOperators = 2000, kMostBranches = 1000;

  std::vector<Token> tokens_;
  Script& script_;
  ScriptErrors& errors_;
  std::size_t at_ = 0;
  int depth_ = 0, brackets_ = 0, operators_ = 0;
};

}  // namespace

bool parse(std::string_view text, Script& script, ScriptError& error) {
  ScriptErrors errors;
  if (parse(text, script, errors)) return true;
  error = std::move(errors.front());
  return false;
}

bool parse(std::string_view text, Script& script, ScriptErrors& errors) {
  std::vector<Token> tokens;
  tokenize(text, tokens, errors);
  Parser(std::move(tokens), script, errors).run();
  std::ranges::sort(errors, {}, [](const ScriptError& one) { return std::tuple(one.line, one.column, one.text); });
  return errors.empty();
}

}  // namespace takt::languages::urscript
