#include "hw/emulators/rtde/script_intake.h"

#include <algorithm>
#include <array>
#include <vector>

#include "hw/emulators/rtde/language.h"
#include "languages/urscript/lexer.h"

namespace takt::hw::rtde {

namespace {

bool begins_program(std::string_view line) { return line.starts_with("def ") || line.starts_with("sec "); }

/// How many blocks begin in a line, less those that end in it. Of a line that cannot be read its first words count.
int blocks_in(std::string_view line) {
  static constexpr std::array<std::string_view, 5> kBegin = {"def", "sec", "thread", "if", "while"};
  std::vector<urscript::Token> tokens;
  urscript::ScriptError error;
  (void)urscript::tokenize(line, tokens, error);
  int blocks = 0;
  for (const urscript::Token& token : tokens) {
    if (token.kind != urscript::Token::Kind::kName) continue;
    if (std::ranges::find(kBegin, token.text) != kBegin.end()) ++blocks;
    if (token.text == "end") --blocks;
  }
  return blocks;
}

}  // namespace

void ScriptIntake::feed(std::string_view bytes) {
  buffer_.erase(0, begin_);
  searched_ -= std::min(searched_, begin_);
  begin_ = 0;
  buffer_.append(bytes);
  if (buffer_.size() <= kLargest) return;
  buffer_.clear();
  searched_ = 0;
  open_ = 0;
  ++dropped_;
}

std::optional<ScriptIntake::Piece> ScriptIntake::next() {
  for (;;) {
    const std::size_t end = buffer_.find('\n', begin_);
    if (end == std::string::npos) return std::nullopt;
    const std::string_view line = std::string_view(buffer_).substr(begin_, end - begin_);
    if (begins_program(line)) break;
    const bool empty = line.find_first_not_of(" \t\r") == std::string_view::npos;
    if (!empty) return take(end + 1, false);
    begin_ = end + 1;
  }
  // Whole lines only: what has come so far may be the first part of a longer word.
  for (std::size_t at = std::max(searched_, begin_);;) {
    const std::size_t end = buffer_.find('\n', at);
    if (end == std::string::npos) {
      searched_ = at;
      return std::nullopt;
    }
    open_ += blocks_in(std::string_view(buffer_).substr(at, end - at));
    if (open_ <= 0) return take(end + 1, true);
    at = end + 1;
  }
}

/// Up to `end` in the buffer.
ScriptIntake::Piece ScriptIntake::take(std::size_t end, bool is_program) {
  Piece piece{buffer_.substr(begin_, end - begin_), is_program};
  begin_ = searched_ = end;
  open_ = 0;
  return piece;
}

}  // namespace takt::hw::rtde
