#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "languages/urscript/syntax.h"

namespace takt::languages::urscript {

/// A thread of the machine that waits: asked once in each frame, it gives the value of the call that waited, or
/// nothing yet.
using Wait = std::function<std::optional<Value>()>;
/// A call that cannot be: the program ends with this text.
struct Failed {
  std::string text;
};
/// What a built-in function gives: at once, later, or never.
using Outcome = std::variant<Value, Wait, Failed>;

/// A call of a built-in function. Arguments stand in the order of its parameters; what was not given and has no default
/// is nothing.
struct Call {
  std::span<const Value> arguments;
  int thread = 0;  ///< that calls; > 0, unique in the program
};

/// A built-in function.
struct Builtin {
  std::string name;
  std::vector<Parameter> parameters;
  std::function<Outcome(const Call&)> run;
  bool repeats = false;  ///< takes any number of further arguments
  bool pure = false;     ///< needs nothing but its arguments
};

/// The built-in functions that scripts may call.
class Library {
 public:
  /// @param signature  "movej(q, a=1.4, v=1.05)"; a last parameter "..." takes any number more; "m|mass" is one
  /// parameter of two names. Well-formed; a default is a number, True, False or a string.
  void add(std::string_view signature, std::function<Outcome(const Call&)> run);
  /// All that have been added need nothing but their arguments.
  void mark_pure() {
    for (Builtin& one : all_) one.pure = true;
  }
  [[nodiscard]] const std::vector<Builtin>& all() const { return all_; }
  /// @return -1: there is none.
  [[nodiscard]] int find(std::string_view name) const;

 private:
  std::vector<Builtin> all_;
};

/// One instruction of the machine; `a` and `b` as the code says.
struct Instruction {
  enum class Code : std::uint8_t {
    kConstant,       ///< push constants[a]
    kLoadLocal,      ///< push locals[a]
    kLoadGlobal,     ///< push globals[a]
    kStoreLocal,     ///< pop into locals[a]
    kStoreGlobal,    ///< pop into globals[a]
    kStoreLocalAt,   ///< pop value and b indices: an element of locals[a]
    kStoreGlobalAt,  ///< the same of globals[a]
    kIndex,          ///< pop a indices and what they index; push the element
    kList,           ///< pop a values; push them as a list
    kPose,           ///< pop six numbers
    kOperator,       ///< pop two; a is the Operator
    kNegate,
    kNot,
    kPop,
    kJump,         ///< to a
    kJumpBack,     ///< to a, to an earlier instruction
    kJumpIfFalse,  ///< pop; to a
    kShortAnd,     ///< if the top is false: it stays, to a; else pop
    kShortOr,      ///< if the top is true: it stays, to a; else pop
    kCall,         ///< function a with b arguments
    kBuiltin,      ///< built-in function a with b arguments
    kRun,          ///< function a with b arguments in a thread of its own; push its handle
    kReturn,       ///< pop the value of the function
    kKill,         ///< pop a handle
    kJoin,         ///< pop a handle; wait until that thread has ended
    kHalt
  };
  Code code = Code::kHalt;
  int a = 0, b = 0;
  int line = 1, column = 1;
};

struct CompiledFunction {
  std::string name;
  std::size_t begin = 0;  ///< its first instruction
  int parameters = 0, locals = 0;
};

/// Where a program calls a built-in function.
struct BuiltinCall {
  std::string name;
  std::optional<Value> first = {};  ///< its first argument, if that is a constant
  int line = 1, column = 1;
};

/// A statement of the main program, with its code.
struct MainStatement {
  int line = 1;
  std::size_t begin = 0, end = 0;
  bool assigns = false;  ///< an assignment that needs nothing but variables before it
};

/// A compiled program. Function 0 is what runs. Immutable, independent of the library but for the numbers of its
/// functions.
struct Program {
  std::string name;
  bool secondary = false;
  std::vector<Instruction> code;
  std::vector<Value> constants;
  std::vector<CompiledFunction> functions;
  int globals = 0;
  std::vector<BuiltinCall> calls;         ///< in the order of the code
  std::vector<MainStatement> statements;  ///< of the main program, also those in its blocks, in the order of the code
};

/// Compiles a script. Which names are global: those that are declared so anywhere, and those that the main program
/// assigns.
/// @return null and the first error: a name that nobody knows is "compile_error_name_not_found:NAME:". Realtime: setup.
[[nodiscard]] std::shared_ptr<const Program> compile(const Script& script, const Library& library, ScriptError& error);
/// Parses and compiles with all errors. The program has these global variables before the others, in this order.
[[nodiscard]] std::shared_ptr<const Program> compile(const Script& script, const Library& library, ScriptErrors& errors,
                                                     std::span<const std::string> given = {});
[[nodiscard]] std::shared_ptr<const Program> compile(std::string_view text, const Library& library,
                                                     ScriptErrors& errors, std::span<const std::string> given = {});
/// Parses and compiles.
[[nodiscard]] std::shared_ptr<const Program> compile(std::string_view text, const Library& library, ScriptError& error);

}  // namespace takt::languages::urscript
