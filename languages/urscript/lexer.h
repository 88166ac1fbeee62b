#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "languages/urscript/value.h"

namespace takt::languages::urscript {

/// What is wrong with a script, or with what it does: 1-based line and column, and a text for people and clients.
struct ScriptError {
  int line = 1, column = 1;
  std::string text;
  std::string unknown = {};  ///< name of a function or a variable that is not known
  bool is_call = false;      ///< it is a function's
};
/// All that is wrong with a script, in the order found; it is not read on after so many.
using ScriptErrors = std::vector<ScriptError>;
constexpr std::size_t kMostErrors = 50;

struct Token {
  enum class Kind : std::uint8_t { kName, kNumber, kString, kSign, kEnd };
  Kind kind = Kind::kEnd;
  std::string text;  ///< name, sign, or what a string holds
  Value value;       ///< of a number
  int line = 1, column = 1;
  bool begins_line = false;  ///< the first one of its line

  [[nodiscard]] bool is(std::string_view word) const {
    return (kind == Kind::kName || kind == Kind::kSign) && text == word;
  }
};

/// The words of a script; the last one is kEnd. Comments (`# ...`) and labels of a program tree (`$ ...`) are left out.
/// @return false and the error for a character that no word begins with, or a string without its end.
[[nodiscard]] bool tokenize(std::string_view script, std::vector<Token>& tokens, ScriptError& error);
/// The same with all errors; what is wrong is left out.
void tokenize(std::string_view script, std::vector<Token>& tokens, ScriptErrors& errors);

}  // namespace takt::languages::urscript
