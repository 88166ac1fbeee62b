#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace takt::hw::rtde {

/// Cuts what a client sends to a script port into programs and single lines. A program begins with `def` or `sec` in
/// the first column and ends with the `end` that belongs to it; the client keeps its connection open, so that is found
/// in the text. Words in texts and comments do not count.
/// Holds at most kLargest bytes; a program that is longer is dropped. One thread.
class ScriptIntake {
 public:
  static constexpr std::size_t kLargest = 1u << 20;

  struct Piece {
    std::string text;
    bool is_program = false;
  };

  void feed(std::string_view bytes);
  /// The next program, or line that is not empty.
  [[nodiscard]] std::optional<Piece> next();
  /// Programs that were too long.
  [[nodiscard]] int dropped() const { return dropped_; }

 private:
  Piece take(std::size_t end, bool is_program);

  std::string buffer_;
  std::size_t begin_ = 0;     // of what is not yet taken
  std::size_t searched_ = 0;  // of a program: no end stands before
  int open_ = 0;              // blocks of that program that have begun before `searched_` and not ended
  int dropped_ = 0;
};

}  // namespace takt::hw::rtde
