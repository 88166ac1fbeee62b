#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/diagnostics.h"

/// The scripts of behaviour trees: numbers and texts, assignments, arithmetic, comparisons, logic, a choice. Realtime:
/// setup.
namespace takt::languages {

/// What an entry of a blackboard, or an expression, is worth.
struct TreeValue {
  std::variant<std::monostate, double, std::string> value;  ///< nothing: unset

  [[nodiscard]] bool is_set() const { return value.index() != 0; }
  [[nodiscard]] bool is_number() const { return value.index() == 1; }
  [[nodiscard]] double number() const { return std::get<double>(value); }
  [[nodiscard]] const std::string& text() const { return std::get<std::string>(value); }
  /// 3, 0.5, or the text.
  [[nodiscard]] std::string to_text() const;
  /// A number if the text is one from its begin to its end; "true" and "false" are 1 and 0.
  [[nodiscard]] static TreeValue of_text(std::string_view text);
  bool operator==(const TreeValue&) const = default;
};

/// Where scripts find entries.
class TreeVariables {
 public:
  virtual ~TreeVariables() = default;
  /// Null: there is none.
  [[nodiscard]] virtual const TreeValue* find(const std::string& name) const = 0;
  virtual void set(const std::string& name, TreeValue value) = 0;
};

/// A script, parsed once. Immutable.
class TreeScript {
 public:
  struct Node;
  /// @return the script; or what is wrong with it, with the number of the character
  [[nodiscard]] static Result<TreeScript> parse(std::string_view text);

  /// Its last statement's value. @return nothing, with the reason, where a name is unknown or types do not fit
  [[nodiscard]] Result<TreeValue> run(TreeVariables& variables) const;
  /// It says nothing.
  [[nodiscard]] bool empty() const { return statements_.empty(); }

 private:
  std::vector<std::shared_ptr<const Node>> statements_;
};

/// Whether a value counts as true: a number that is not 0. Nothing: it is no number.
[[nodiscard]] std::optional<bool> truth_of(const TreeValue& value);

}  // namespace takt::languages
