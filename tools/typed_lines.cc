#include "tools/typed_lines.h"

#include <array>

#include <poll.h>
#include <unistd.h>

namespace takt::tools {
namespace {

constexpr std::size_t kLongestLine = 4096;  // of a line; more is nobody's typing

bool may_read() { return isatty(STDIN_FILENO) == 0 || tcgetpgrp(STDIN_FILENO) == getpgrp(); }

}  // namespace

std::optional<std::string> TypedLines::next() {
  if (text_.find('\n') == std::string::npos) read_what_is_there();
  const auto end = text_.find('\n');
  if (end == std::string::npos) {
    if (text_.size() > kLongestLine) text_.clear();
    return std::nullopt;
  }
  std::string line = text_.substr(0, end);
  text_.erase(0, end + 1);
  return line;
}

void TypedLines::read_what_is_there() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  if (ended_ || !may_read() || poll(&input, 1, 0) <= 0) return;
  std::array<char, 512> bytes;
  const ssize_t count = read(STDIN_FILENO, bytes.data(), bytes.size());
  if (count > 0) text_.append(bytes.data(), static_cast<std::size_t>(count));
  if (count == 0) ended_ = true;
}

}  // namespace takt::tools
