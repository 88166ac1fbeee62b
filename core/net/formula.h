#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/net/registry.h"

namespace takt::net {

/// A number in a formula: an input, or a literal.
struct FormulaNumber {
  int input = -1;  ///< -1: `literal`
  double literal = 0.0;
};

/// What a Boolean output means in terms of the inputs of its primitive, ready to be evaluated with a stack.
/// Private to core/net.
struct Formula {
  struct Step {
    enum class Kind { kInput, kConstant, kUnknown, kNot, kAnd, kOr, kXor, kElse, kIsNull, kEqual, kLess, kLessEqual };
    Kind kind = Kind::kUnknown;
    int input = -1;         ///< kInput, kIsNull
    bool constant = false;  ///< kConstant
    FormulaNumber a, b;     ///< comparisons
  };
  std::vector<Step> steps;  ///< operands before their operators
};

/// Reads the text of Setup::means(). From loose to tight: `??`, `|`, `^`, `&`, `!`.
/// @return std::nullopt if the text is malformed or names what is no input, or one of the wrong type. Realtime: setup.
[[nodiscard]] std::optional<Formula> parse_formula(std::string_view text, const PrimitiveInfo& info);

}  // namespace takt::net
