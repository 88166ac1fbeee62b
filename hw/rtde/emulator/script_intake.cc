#include "hw/rtde/emulator/script_intake.h"

#include <algorithm>

namespace takt::rtde {

namespace {

bool begins_program(std::string_view line) { return line.starts_with("def ") || line.starts_with("sec "); }

/// A line that is "end", with blanks behind it.
bool ends_program(std::string_view line) {
  if (!line.starts_with("end")) return false;
  line.remove_prefix(3);
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
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
    if (ends_program(std::string_view(buffer_).substr(at, end - at))) return take(end + 1, true);
    at = end + 1;
  }
}

/// Up to `end` in the buffer.
ScriptIntake::Piece ScriptIntake::take(std::size_t end, bool is_program) {
  Piece piece{buffer_.substr(begin_, end - begin_), is_program};
  begin_ = end;
  return piece;
}

}  // namespace takt::rtde
