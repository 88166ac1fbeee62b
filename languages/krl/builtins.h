#pragma once

#include <span>
#include <string>
#include <string_view>

#include "languages/krl/syntax.h"

namespace takt::languages::krl {

/// A function that every program has.
struct Builtin {
  std::string_view name;
  std::size_t arguments;
  /// @return empty, or what is wrong
  std::string (*call)(std::span<const Value> arguments, Value& result);
};

/// Null: there is none.
[[nodiscard]] const Builtin* find_builtin(std::string_view name);

/// Arithmetic, comparison, logic, the geometric operator. @return empty, or what is wrong
[[nodiscard]] std::string operate(Operator op, const Value& left, const Value& right, Value& result);
[[nodiscard]] std::string operate(Operator op, const Value& operand, Value& result);
[[nodiscard]] bool equal(const Value& left, const Value& right);

}  // namespace takt::languages::krl
