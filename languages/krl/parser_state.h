#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "languages/krl/lexer.h"
#include "languages/krl/syntax.h"

namespace takt::languages::krl {

/// Where a parser is in the words of one file. After the first error of a line the rest of that line is skipped.
class ParserState {
 public:
  ParserState(std::string_view text, const std::string& file, Diagnostics& diagnostics);

  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const;
  [[nodiscard]] bool sees(std::string_view word) const { return peek().is(word); }
  [[nodiscard]] bool at_line_end() const {
    return peek().kind == Token::Kind::kLineEnd || peek().kind == Token::Kind::kEnd;
  }
  [[nodiscard]] bool at_end() const { return peek().kind == Token::Kind::kEnd; }
  Token take();
  /// Takes the word if it is there.
  bool accept(std::string_view word);
  /// Takes the word, or says that it is missing.
  bool expect(std::string_view word);
  std::string expect_name(std::string_view what);
  /// Nothing else is on this line.
  void end_line();
  void skip_line();
  void skip_empty_lines();
  void error(const TextLocation& at, Code code, std::string message, std::string hint = {});
  /// The text of the line from here on, without its comment.
  [[nodiscard]] std::string rest_of_line() const;

  ExpressionPtr expression();
  /// A name with fields and indices, or a call.
  ExpressionPtr primary();
  std::vector<ExpressionPtr> list(std::string_view end);

  static constexpr int kMostDepth = 64;
  int depth = 0;

 private:
  ExpressionPtr binary(std::size_t level);
  ExpressionPtr unary();
  ExpressionPtr geometric();
  ExpressionPtr aggregate();
  ExpressionPtr suffixes(ExpressionPtr inner);
  ExpressionPtr missing(std::string_view what);

  std::string_view text_;
  std::vector<std::size_t> lines_;
  const std::string& file_;
  Diagnostics& diagnostics_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  int wrong_line_ = 0;
};

}  // namespace takt::languages::krl
