#include "languages/urscript/lexer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include <fmt/format.h>

namespace takt::languages::urscript {

namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

constexpr std::array<std::string_view, 4> kLongSigns = {"==", "!=", "<=", ">="};
constexpr std::string_view kSigns = "()[],:=+-*/%<>.;{}";

/// Cuts a script into words.
class Lexer {
 public:
  Lexer(std::string_view script, std::vector<Token>& tokens) : script_(script), tokens_(tokens) {}

  void run(ScriptErrors& errors) {
    while (skip_blanks() && errors.size() < kMostErrors) {
      if (take()) continue;
      ScriptError& error = errors.emplace_back();
      error.line = line_;
      error.column = column();
      error.text = problem_;
      // A text without its end takes the rest of its line with it.
      const bool text = here() == '"' || here() == '\'';
      at_ = text ? std::min(script_.find('\n', at_), script_.size()) : at_ + 1;
    }
    add(Token::Kind::kEnd, at_, at_);
  }

 private:
  [[nodiscard]] int column() const { return static_cast<int>(at_ - line_begin_) + 1; }
  [[nodiscard]] char here() const { return at_ < script_.size() ? script_[at_] : '\0'; }

  /// To the next word. @return false at the end.
  bool skip_blanks() {
    for (; at_ < script_.size(); ++at_) {
      const char c = here();
      if (c == '\n') {
        begin_line();
      } else if (c == '#' || (c == '$' && begins_line_)) {
        at_ = std::min(script_.find('\n', at_), script_.size()) - 1;
      } else if (!is_blank(c)) {
        return true;
      }
    }
    return false;
  }
  void begin_line() {
    ++line_;
    line_begin_ = at_ + 1;
    begins_line_ = true;
  }

  bool take() {
    if (is_letter(here())) return take_name();
    const bool fraction = here() == '.' && at_ + 1 < script_.size() && is_digit(script_[at_ + 1]);
    if (is_digit(here()) || fraction) return take_number();
    if (here() == '"' || here() == '\'') return take_string();
    return take_sign();
  }
  bool take_name() {
    const std::size_t from = at_;
    while (is_letter(here()) || is_digit(here())) ++at_;
    add(Token::Kind::kName, from, at_);
    return true;
  }
  bool take_number() {
    const std::size_t from = at_;
    const char *begin = script_.data() + at_, *end = script_.data() + script_.size();
    std::int32_t integer = 0;
    double real = 0.0;
    const auto as_integer = std::from_chars(begin, end, integer);
    const auto as_real = std::from_chars(begin, end, real);
    const bool whole = as_integer.ec == std::errc() && as_integer.ptr == as_real.ptr;
    if (!whole && as_real.ec != std::errc()) return fail("a number that no computer holds");
    at_ += static_cast<std::size_t>(as_real.ptr - begin);
    add(Token::Kind::kNumber, from, at_);
    tokens_.back().value = whole ? Value(integer) : Value(real);
    return true;
  }
  bool take_string() {
    const char quote = here();
    const std::size_t end = script_.find(quote, at_ + 1);
    const std::size_t line_end = std::min(script_.find('\n', at_), script_.size());
    if (end > line_end) return fail("a string without its end");
    add(Token::Kind::kString, at_ + 1, end);
    at_ = end + 1;
    return true;
  }
  bool take_sign() {
    for (const std::string_view sign : kLongSigns)
      if (script_.substr(at_, 2) == sign) return take_sign(2);
    if (kSigns.find(here()) != std::string_view::npos) return take_sign(1);
    return fail(fmt::format("unexpected character '{}'", here() >= ' ' ? here() : '?'));
  }
  bool take_sign(std::size_t length) {
    add(Token::Kind::kSign, at_, at_ + length);
    at_ += length;
    return true;
  }
  bool fail(std::string problem) {
    problem_ = std::move(problem);
    return false;
  }
  void add(Token::Kind kind, std::size_t from, std::size_t to) {
    Token& token = tokens_.emplace_back();
    token.kind = kind;
    token.text = script_.substr(from, to - from);
    token.line = line_;
    token.column = static_cast<int>(from - line_begin_) + 1;
    token.begins_line = std::exchange(begins_line_, false);
  }

  std::string_view script_;
  std::vector<Token>& tokens_;
  std::size_t at_ = 0, line_begin_ = 0;
  int line_ = 1;
  bool begins_line_ = true;
  std::string problem_;
};

}  // namespace

bool tokenize(std::string_view script, std::vector<Token>& tokens, ScriptError& error) {
  ScriptErrors errors;
  tokenize(script, tokens, errors);
  if (!errors.empty()) error = errors.front();
  return errors.empty();
}

void tokenize(std::string_view script, std::vector<Token>& tokens, ScriptErrors& errors) {
  Lexer(script, tokens).run(errors);
}

}  // namespace takt::languages::urscript
