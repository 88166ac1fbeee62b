#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/expression/contact_reader.h"
#include "core/program/language/value.h"

namespace takt::activity {
struct Variables;
}  // namespace takt::activity

namespace takt::program {

/// What an expression can see.
struct EvalContext {
  /// kCheck: types only, all is unknown that only a rehearsal or a run can know. kRehearse: nominal values; devices are
  /// not asked. kRun: everything.
  enum class Mode { kCheck, kRehearse, kRun };
  Mode mode = Mode::kCheck;
  const Scope* scope = nullptr;
  const expression::Cell* cell = nullptr;
  const activity::Variables* measured = nullptr;  ///< in a run
  /// In a rehearsal: where the arms would be, rad or m.
  const std::map<std::string, kinematics::JointVector, std::less<>>* q = nullptr;
  Nanoseconds time = 0;                           ///< simulated, in a run
  expression::ContactReaders* readers = nullptr;  ///< of who asks in every cycle; null: each answer is compiled anew

  [[nodiscard]] bool rehearsing() const { return mode == Mode::kRehearse; }
  [[nodiscard]] bool running() const { return mode == Mode::kRun; }
};

/// A node of an expression's tree.
struct ExpressionNode {
  enum class Kind { kConstant, kVariable, kCall, kNegate, kNot, kBinary, kIndex, kList };
  Kind kind = Kind::kConstant;
  std::string name;  ///< of a variable, function, operator
  Value value;       ///< of a constant
  std::vector<ExpressionNode> children;
  std::size_t at = 0;  ///< character in the text
};

/// An expression of a program: arithmetic with units, comparisons, logic of three values (row N2), texts, poses, lists,
/// functions that ask the cell. docs/programs.md has the grammar. Immutable.
class Expression {
 public:
  /// @param text  without the "$" that marks it in a file. Diagnostics say at which character. Realtime: setup.
  [[nodiscard]] static Result<Expression> parse(std::string_view text);

  /// What is not known gives null of the right type, so checking types is evaluating with nothing known.
  /// Diagnostics, without a pointer: all that is wrong. Realtime: setup.
  [[nodiscard]] Value evaluate(const EvalContext& eval_context, Diagnostics& diagnostics) const;
  [[nodiscard]] const std::string& text() const { return text_; }
  /// What it is worth changes while machines move: it asks where they are, for an input, the time.
  [[nodiscard]] bool changes(const expression::Cell& cell) const;

 private:
  std::string text_;
  std::shared_ptr<const ExpressionNode> root_;
};

/// A text in a file that is an expression: it begins with "$", and not with "$$", which means a "$".
[[nodiscard]] bool is_expression(std::string_view text);

/// A function of the language.
struct Function {
  std::string_view name;
  /// A letter per argument: b Boolean, n number, d number without a unit, l length, a angle, t text, p pose, L list,
  /// * anything; those after '?' may be left out.
  std::string_view arguments;
  std::string_view doc;
  struct Call {
    const EvalContext& eval_context;
    const std::vector<Value>& arguments;
    std::vector<std::string>& errors;  ///< what is wrong, without the location
    bool all_known;                    ///< no argument is null
  };
  Value (*call)(Call& call);
  /// Whether its answer changes while machines move: of kFrames only if one of the frames that it is asked for does.
  enum class Changes { kNever, kFrames, kAlways };
  Changes changes = Changes::kNever;
};

/// All functions, by name.
[[nodiscard]] const std::vector<Function>& functions();

}  // namespace takt::program
