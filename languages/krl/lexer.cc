#include "languages/krl/lexer.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace takt::languages::krl {
namespace {

constexpr std::size_t kMostBytes = 1u << 20;
constexpr std::size_t kMostTokens = 400'000;
constexpr std::size_t kMostInLine = 1'000;

bool begins_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '$'; }
bool in_name(char c) { return begins_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string in_capitals(std::string_view text) {
  std::string capitals(text);
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

class Lexer {
 public:
  Lexer(std::string_view text, const std::string& file, Diagnostics& diagnostics)
      : text_(text), file_(file), diagnostics_(diagnostics) {}

  std::vector<Token> read() {
    if (text_.size() > kMostBytes) {
      error_at(diagnostics_, file_, {}, Code::kTooLarge, fmt::format("{} bytes", text_.size()),
               fmt::format("Split it: a file has {} bytes at most", kMostBytes));
      text_ = {};
    }
    while (at_ < text_.size() && tokens_.size() < kMostTokens) next();
    end_line();
    add(Token::Kind::kEnd, {});
    return std::move(tokens_);
  }

 private:
  [[nodiscard]] TextLocation here() const { return {line_, static_cast<int>(at_ - line_begin_) + 1}; }
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
  }

  void add(Token::Kind kind, std::string text) { tokens_.push_back({kind, std::move(text), {}, here()}); }

  void next() {
    const char c = text_[at_];
    if (c == '\n') return end_line();
    if (c == ' ' || c == '\t' || c == '\r') {
      ++at_;
    } else if (c == ';' || (c == '&' && only_spaces_before())) {
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    } else if (begins_name(c)) {
      name(Token::Kind::kName, at_);
    } else if (is_digit(c) || (c == '.' && is_digit(peek(1)))) {
      number();
    } else if (c == '"') {
      string();
    } else if (c == '\'') {
      based_number();
    } else if (c == '#' && begins_name(peek(1))) {
      const std::size_t begin = at_++;
      name(Token::Kind::kConstant, begin);
    } else {
      sign();
    }
  }

  [[nodiscard]] bool only_spaces_before() const {
    return text_.substr(line_begin_, at_ - line_begin_).find_first_not_of(" \t\r") == std::string_view::npos;
  }

  /// The words of a line bound how deep its expressions nest.
  void end_line() {
    if (tokens_.size() - line_tokens_ > kMostInLine) {
      error_at(diagnostics_, file_, {line_, 1}, Code::kTooLarge,
               fmt::format("{} words in a line", tokens_.size() - line_tokens_),
               fmt::format("Use {} at most", kMostInLine));
      tokens_.resize(line_tokens_);
    }
    add(Token::Kind::kLineEnd, {});
    ++at_;
    ++line_;
    line_begin_ = at_;
    line_tokens_ = tokens_.size();
  }

  void name(Token::Kind kind, std::size_t begin) {
    const TextLocation at{line_, static_cast<int>(begin - line_begin_) + 1};
    const std::size_t first = at_;
    while (at_ < text_.size() && in_name(text_[at_])) ++at_;
    tokens_.push_back({kind, in_capitals(text_.substr(first, at_ - first)), {}, at});
  }

  void number() {
    Token token{Token::Kind::kNumber, {}, {}, here()};
    const std::size_t begin = at_;
    while (is_digit(peek())) ++at_;
    bool real = false;
    if (peek() == '.') {
      real = true;
      ++at_;
      while (is_digit(peek())) ++at_;
    }
    const std::size_t sign = peek(1) == '+' || peek(1) == '-' ? 2 : 1;
    if ((peek() == 'e' || peek() == 'E') && is_digit(peek(sign))) {
      real = true;
      at_ += sign;
      while (is_digit(peek())) ++at_;
    }
    token.text = std::string(text_.substr(begin, at_ - begin));
    double value = 0.0;
    const auto [end, error] = std::from_chars(token.text.data(), token.text.data() + token.text.size(), value);
    if (error != std::errc{} || !std::isfinite(value))
      error_at(diagnostics_, file_, token.at, Code::kOutOfRange, fmt::format("'{}' is out of range", token.text),
               "Give a smaller number");
    token.value = real || value > 2147483647.0 ? Value::of(value) : Value::of(static_cast<std::int64_t>(value));
    tokens_.push_back(std::move(token));
  }

  /// 'HFF' and 'B101'.
  void based_number() {
    Token token{Token::Kind::kNumber, {}, {}, here()};
    const std::size_t end = text_.find('\'', at_ + 1);
    const std::string inside =
        end == std::string_view::npos ? std::string() : in_capitals(text_.substr(at_ + 1, end - at_ - 1));
    const int base = inside.starts_with('H') ? 16 : inside.starts_with('B') ? 2 : 0;
    std::int64_t value = 0;
    const char* const first = inside.data() + (inside.empty() ? 0 : 1);
    const char* const last = inside.data() + inside.size();
    const auto read = base == 0 ? std::from_chars_result{first, std::errc::invalid_argument}
                                : std::from_chars(first, last, value, base);
    if (read.ec != std::errc{} || read.ptr != last || value < 0 || value > 4294967295) {
      error_at(diagnostics_, file_, token.at, Code::kSyntax, "not a number in quotes", "Write 'HFF' or 'B101'");
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      return;
    }
    token.value = Value::of(static_cast<std::int64_t>(static_cast<std::int32_t>(value)));
    at_ = end + 1;
    tokens_.push_back(std::move(token));
  }

  void string() {
    Token token{Token::Kind::kText, {}, {}, here()};
    const std::size_t end = text_.find_first_of("\"\n", at_ + 1);
    if (end == std::string_view::npos || text_[end] == '\n') {
      error_at(diagnostics_, file_, token.at, Code::kSyntax, "a text without its end", "Close it with \"");
      at_ = end == std::string_view::npos ? text_.size() : end;
      return;
    }
    token.text = std::string(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    tokens_.push_back(std::move(token));
  }

  void sign() {
    constexpr std::array<std::string_view, 22> kSigns{"==", "<>", "<=", ">=", "=", "<", ">", "+", "-", "*", "/",
                                                      ":",  "(",  ")",  "[",  "]", "{", "}", ",", ".", "#", "?"};
    for (const std::string_view sign : kSigns) {
      if (text_.substr(at_, sign.size()) != sign) continue;
      add(Token::Kind::kSign, std::string(sign));
      at_ += sign.size();
      return;
    }
    const auto byte = static_cast<unsigned char>(text_[at_]);
    error_at(diagnostics_, file_, here(), Code::kSyntax,
             byte > 32 && byte < 127 ? fmt::format("unexpected character '{}'", text_[at_])
                                     : fmt::format("unexpected byte 0x{:02x}", byte),
             "Remove it, or put it into a comment");
    ++at_;
  }

  std::string_view text_;
  const std::string& file_;
  Diagnostics& diagnostics_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0, line_begin_ = 0, line_tokens_ = 0;
  int line_ = 1;
};

}  // namespace

void error_at(Diagnostics& diagnostics, const std::string& file, const TextLocation& at, Code code, std::string message,
              std::string hint) {
  constexpr std::size_t kMost = 200;  // more do not help anybody
  if (diagnostics.list().size() >= kMost) return;
  diagnostics.add({.severity = Severity::kError,
                   .code = code,
                   .file = file,
                   .pointer = {},
                   .message = std::move(message),
                   .hint = std::move(hint),
                   .line = at.line,
                   .column = at.column});
}

std::vector<Token> tokenize(std::string_view text, const std::string& file, Diagnostics& diagnostics) {
  return Lexer(text, file, diagnostics).read();
}

}  // namespace takt::languages::krl
