// Words and expressions.
#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "languages/krl/parser_state.h"

namespace takt::languages::krl {
namespace {

struct OperatorWord {
  std::string_view word;
  Operator op;
};

/// From what binds least to what binds most: comparisons bind least of all in KRL.
constexpr std::array<OperatorWord, 6> kComparisons{{{"==", Operator::kEqual},
                                                    {"<>", Operator::kNotEqual},
                                                    {"<=", Operator::kLessEqual},
                                                    {">=", Operator::kGreaterEqual},
                                                    {"<", Operator::kLess},
                                                    {">", Operator::kGreater}}};
constexpr std::array<OperatorWord, 2> kOrs{{{"OR", Operator::kOr}, {"B_OR", Operator::kBitOr}}};
constexpr std::array<OperatorWord, 2> kExors{{{"EXOR", Operator::kExor}, {"B_EXOR", Operator::kBitExor}}};
constexpr std::array<OperatorWord, 2> kAnds{{{"AND", Operator::kAnd}, {"B_AND", Operator::kBitAnd}}};
constexpr std::array<OperatorWord, 2> kSums{{{"+", Operator::kAdd}, {"-", Operator::kSubtract}}};
constexpr std::array<OperatorWord, 2> kProducts{{{"*", Operator::kMultiply}, {"/", Operator::kDivide}}};
constexpr std::array<std::span<const OperatorWord>, 6> kLevels{kComparisons, kOrs, kExors, kAnds, kSums, kProducts};

ExpressionPtr make(Expression::Kind kind, const TextLocation& at) {
  auto made = std::make_unique<Expression>();
  made->kind = kind;
  made->at = at;
  return made;
}

std::string shown(const Token& token) {
  switch (token.kind) {
    case Token::Kind::kLineEnd:
      return "end of the line";
    case Token::Kind::kEnd:
      return "end of the file";
    case Token::Kind::kConstant:
      return "'#" + token.text + "'";
    case Token::Kind::kText:
      return "text";
    case Token::Kind::kNumber:
      return "number";
    default:
      return "'" + token.text + "'";
  }
}

}  // namespace

ParserState::ParserState(std::string_view text, const std::string& file, Diagnostics& diagnostics)
    : text_(text), file_(file), diagnostics_(diagnostics), tokens_(tokenize(text, file, diagnostics)) {
  lines_.push_back(0);
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') lines_.push_back(i + 1);
}

const Token& ParserState::peek(std::size_t ahead) const { return tokens_[std::min(at_ + ahead, tokens_.size() - 1)]; }

Token ParserState::take() {
  Token token = peek();
  if (at_ + 1 < tokens_.size()) ++at_;
  return token;
}

bool ParserState::accept(std::string_view word) {
  if (!sees(word)) return false;
  (void)take();
  return true;
}

bool ParserState::expect(std::string_view word) {
  if (accept(word)) return true;
  error(peek().at, Code::kSyntax, "unexpected " + shown(peek()), fmt::format("Write '{}' here", word));
  return false;
}

std::string ParserState::expect_name(std::string_view what) {
  if (peek().kind == Token::Kind::kName) return take().text;
  error(peek().at, Code::kSyntax, "unexpected " + shown(peek()), fmt::format("Write {}", what));
  return {};
}

void ParserState::end_line() {
  if (!at_line_end()) error(peek().at, Code::kSyntax, "unexpected " + shown(peek()), "End the line here");
  skip_line();
}

void ParserState::skip_line() {
  while (!at_line_end()) (void)take();
  if (!at_end()) (void)take();
}

void ParserState::skip_empty_lines() {
  while (peek().kind == Token::Kind::kLineEnd) (void)take();
}

void ParserState::error(const TextLocation& at, Code code, std::string message, std::string hint) {
  if (wrong_line_ == at.line) return;
  wrong_line_ = at.line;
  error_at(diagnostics_, file_, at, code, std::move(message), std::move(hint));
}

std::string ParserState::rest_of_line() const {
  const auto line = static_cast<std::size_t>(peek().at.line) - 1;
  if (line >= lines_.size()) return {};
  const std::size_t begin = lines_[line] + static_cast<std::size_t>(peek().at.column) - 1;
  std::string rest(text_.substr(begin, text_.find_first_of(";\n", begin) - begin));
  while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\r' || rest.back() == '\t')) rest.pop_back();
  return rest;
}

ExpressionPtr ParserState::missing(std::string_view what) {
  error(peek().at, Code::kSyntax, "unexpected " + shown(peek()), fmt::format("Write {}", what));
  return make(Expression::Kind::kLiteral, peek().at);
}

ExpressionPtr ParserState::expression() {
  if (depth >= kMostDepth) {
    error(peek().at, Code::kTooLarge, fmt::format("more than {} levels", kMostDepth), "Split the expression");
    while (!at_line_end()) (void)take();
    return make(Expression::Kind::kLiteral, peek().at);
  }
  ++depth;
  auto made = binary(0);
  --depth;
  return made;
}

ExpressionPtr ParserState::binary(std::size_t level) {
  if (level == kLevels.size()) return unary();
  auto left = binary(level + 1);
  for (int count = 0;; ++count) {
    const auto found = std::ranges::find_if(kLevels[level], [&](const OperatorWord& one) { return sees(one.word); });
    if (found == kLevels[level].end()) return left;
    if (count >= kMostDepth) {
      error(peek().at, Code::kTooLarge, fmt::format("more than {} operators in a row", kMostDepth),
            "Split the expression");
      while (!at_line_end()) (void)take();
      return left;
    }
    auto made = make(Expression::Kind::kBinary, take().at);
    made->op = found->op;
    made->parts.push_back(std::move(left));
    made->parts.push_back(binary(level + 1));
    left = std::move(made);
  }
}

ExpressionPtr ParserState::unary() {
  const TextLocation at = peek().at;
  const Operator op = accept("NOT")     ? Operator::kNot
                      : accept("B_NOT") ? Operator::kBitNot
                      : accept("-")     ? Operator::kNegate
                                        : Operator::kNone;
  if (op == Operator::kNone) {
    (void)accept("+");
    return geometric();
  }
  if (depth >= kMostDepth) return expression();  // which refuses it
  auto made = make(Expression::Kind::kUnary, at);
  made->op = op;
  ++depth;
  made->parts.push_back(unary());
  --depth;
  return made;
}

ExpressionPtr ParserState::geometric() {
  auto left = primary();
  for (int count = 0; sees(":") && count < kMostDepth; ++count) {
    auto made = make(Expression::Kind::kBinary, take().at);
    made->op = Operator::kGeometric;
    made->parts.push_back(std::move(left));
    made->parts.push_back(primary());
    left = std::move(made);
  }
  return left;
}

std::vector<ExpressionPtr> ParserState::list(std::string_view end) {
  std::vector<ExpressionPtr> parts;
  if (accept(end)) return parts;
  do {
    parts.push_back(sees(",") || sees(end) ? nullptr : expression());
  } while (accept(","));
  (void)expect(end);
  return parts;
}

ExpressionPtr ParserState::suffixes(ExpressionPtr inner) {
  for (int count = 0; count < kMostDepth; ++count) {
    const TextLocation at = peek().at;
    if (accept("[")) {
      auto made = make(Expression::Kind::kIndex, inner->at);
      made->parts.push_back(std::move(inner));
      if (!accept("]"))
        for (auto& part : list("]")) {
          if (part == nullptr) {
            error(at, Code::kSyntax, "an index is missing", "Give each index");
            part = make(Expression::Kind::kLiteral, at);
          }
          made->parts.push_back(std::move(part));
        }
      inner = std::move(made);
    } else if (accept(".")) {
      auto made = make(Expression::Kind::kField, inner->at);
      made->parts.push_back(std::move(inner));
      made->name = expect_name("the name of a component");
      inner = std::move(made);
    } else {
      return inner;
    }
  }
  error(peek().at, Code::kTooLarge, "too many indices and components", "Split the expression");
  return inner;
}

ExpressionPtr ParserState::primary() {
  const Token token = peek();
  switch (token.kind) {
    case Token::Kind::kNumber: {
      auto made = make(Expression::Kind::kLiteral, token.at);
      made->value = take().value;
      return made;
    }
    case Token::Kind::kText: {
      auto made = make(Expression::Kind::kLiteral, token.at);
      made->value = Value::string(take().text);
      return made;
    }
    case Token::Kind::kConstant: {
      auto made = make(Expression::Kind::kLiteral, token.at);
      made->value = Value::constant(take().text);
      return made;
    }
    case Token::Kind::kName:
      break;
    default:
      if (token.is("{")) return aggregate();
      if (accept("(")) {
        auto inner = expression();
        (void)expect(")");
        return inner;
      }
      if ((token.is("-") || token.is("+")) && depth < kMostDepth) {
        ++depth;
        auto made = unary();
        --depth;
        return made;
      }
      return missing("a value");
  }
  (void)take();
  if (token.text == "TRUE" || token.text == "FALSE") {
    auto made = make(Expression::Kind::kLiteral, token.at);
    made->value = Value::of(token.text == "TRUE");
    return made;
  }
  auto made = make(Expression::Kind::kName, token.at);
  made->name = token.text;
  if (accept("(")) {
    made->kind = Expression::Kind::kCall;
    made->parts = list(")");
    return made;
  }
  return suffixes(std::move(made));
}

ExpressionPtr ParserState::aggregate() {
  auto made = make(Expression::Kind::kAggregate, take().at);
  if (depth >= kMostDepth) return expression();  // which refuses it
  if (peek().kind == Token::Kind::kName && peek(1).is(":")) {
    made->name = take().text;
    (void)take();
  }
  ++depth;
  while (!sees("}") && !at_line_end()) {
    made->names.push_back(expect_name("the name of a component"));
    if (accept("[")) (void)expect("]");
    made->parts.push_back(expression());
    if (!accept(",")) break;
  }
  --depth;
  (void)expect("}");
  return made;
}

}  // namespace takt::languages::krl
