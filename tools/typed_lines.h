#pragma once

#include <optional>
#include <string>

namespace takt::tools {

/// Lines at the standard input as they come, without ever waiting for one. Nothing is read while the program runs in
/// the background of a terminal, where reading would stop it. Thread: one.
class TypedLines {
 public:
  /// @return a whole line without its end; nullopt: none yet, or no more
  [[nodiscard]] std::optional<std::string> next();

 private:
  void read_what_is_there();

  std::string text_;
  bool ended_ = false;
};

}  // namespace takt::tools
