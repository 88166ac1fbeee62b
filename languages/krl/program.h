#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "languages/krl/parser.h"
#include "languages/krl/syntax.h"

namespace takt::languages::krl {

/// Variables that the machine answers for when they are read: reading or writing one stops the advance run.
enum class Live : std::uint8_t { kIn, kOut, kAnalogIn, kAnalogOut, kPosition, kAxes, kTimer, kTimerStop, kCyclicFlag };

struct Variable {
  std::string name;
  Type type;
  std::vector<int> size;
  bool is_constant = false;
};

/// One instruction of the machine.
struct Instruction {
  enum class Code : std::uint8_t {
    kExecute,      ///< the statement, as its kind says
    kSet,          ///< local x = a
    kCall,         ///< function x with the arguments of a; its result to local y, if it has one
    kJump,         ///< to x
    kJumpBack,     ///< to x, to an earlier instruction
    kJumpIfFalse,  ///< a; to x
    kForTest,      ///< the statement's variable against local y and step y + 1; beyond it to x
    kForStep,      ///< adds the step y + 1
    kCase,         ///< local y equal to a: to x
    kReturn,       ///< with a, if there is one
  };
  Code code = Code::kExecute;
  const Statement* statement = nullptr;
  const Expression* a = nullptr;
  int x = -1, y = -1;
  bool stops = false;  ///< it stops the advance run
};

struct CompiledFunction {
  const Function* source = nullptr;
  int module = 0;
  std::size_t begin = 0;
  std::vector<Variable> locals;  ///< parameters first, then what is declared, then results of calls
  Type result;
};

/// A use of a numbered signal whose number is written as such.
struct SignalUse {
  Live kind = Live::kIn;
  std::int64_t number = 0;
  int module = 0;
  TextLocation at;
  bool is_written = false;
};

/// Modules that belong together, checked and compiled. Immutable.
struct Program {
  std::vector<Module> modules;
  std::vector<std::vector<Variable>> variables;  ///< by module
  std::vector<std::unique_ptr<Structure>> structures;
  std::vector<std::unique_ptr<Enumeration>> enumerations;
  std::vector<CompiledFunction> functions;
  std::vector<Instruction> code;
  std::vector<SignalUse> signals;
  int main = 0;  ///< what runs

  [[nodiscard]] const Structure* structure(std::string_view name) const;
};

/// Reads, checks and compiles: the first module is what runs. A module "$CONFIG" is seen by all others. Diagnostics:
/// all at once, each with file, line and column: syntax, words that are not supported, names that nobody knows.
/// @param calls  names, in capitals, of calls that are carried out outside of the program. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const Program>> compile(const std::vector<ModuleText>& modules,
                                                             const std::set<std::string, std::less<>>& calls);

/// Names of programs that the modules call and do not have. Realtime: setup.
[[nodiscard]] std::set<std::string, std::less<>> missing_programs(const std::vector<ModuleText>& modules);

/// What every program sees, as KRL: types, variables of the machine, BAS.
[[nodiscard]] ModuleText prelude();

}  // namespace takt::languages::krl
