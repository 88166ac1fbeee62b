#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/text_location.h"
#include "languages/krl/value.h"

namespace takt::languages::krl {

struct Token {
  enum class Kind : std::uint8_t { kName, kNumber, kText, kConstant, kSign, kLineEnd, kEnd };
  Kind kind = Kind::kEnd;
  std::string text;  ///< a name in capitals, a sign, what a text holds, the name of a constant
  Value value;       ///< of a number
  TextLocation at;

  [[nodiscard]] bool is(std::string_view word) const {
    return (kind == Kind::kName || kind == Kind::kSign) && text == word;
  }
};

/// Adds a diagnostic with a location in a text.
void error_at(Diagnostics& diagnostics, const std::string& file, const TextLocation& at, Code code, std::string message,
              std::string hint = {});

/// The words of a text: comments, folds and headers (`&...`) are left out; a line ends with kLineEnd, the text with
/// kEnd. Diagnostics: characters that no word has, texts without an end, a text above 1 MiB. Realtime: setup.
[[nodiscard]] std::vector<Token> tokenize(std::string_view text, const std::string& file, Diagnostics& diagnostics);

}  // namespace takt::languages::krl
