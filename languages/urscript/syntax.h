#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "languages/urscript/lexer.h"
#include "languages/urscript/value.h"

/// A script as a tree.
namespace takt::languages::urscript {

struct Expression;
using ExpressionPtr = std::unique_ptr<Expression>;

/// An argument of a call; without a name it counts by its place.
struct Argument {
  std::string name;
  ExpressionPtr value;
};

struct Expression {
  enum class Kind : std::uint8_t {
    kConstant,  ///< value
    kName,      ///< name
    kList,      ///< parts
    kPose,      ///< six parts
    kIndex,     ///< parts: what, indices
    kCall,      ///< name, arguments
    kRun,       ///< name, arguments: starts a thread
    kNegate,    ///< parts[0]
    kNot,       ///< parts[0]
    kOperator   ///< parts[0] op parts[1]
  };
  Kind kind = Kind::kConstant;
  int line = 1, column = 1;
  std::string name;
  Value value;
  Operator op = Operator::kAdd;
  std::vector<ExpressionPtr> parts;
  std::vector<Argument> arguments;
};

struct Statement;
using Block = std::vector<Statement>;

struct Parameter {
  std::string name;
  std::optional<Value> fallback = {};  ///< used where a call gives none
  std::string other_name = {};         ///< by which a call may name it, too; empty: none
};

struct Function {
  std::string name;
  std::vector<Parameter> parameters;
  Block body;
  int line = 1, column = 1;
  bool is_thread = false;
};

struct Statement {
  enum class Kind : std::uint8_t {
    kExpression,  ///< value, whose result is dropped
    kAssign,      ///< target name, indices, value
    kGlobal,      ///< the same, and the name is global
    kLocal,       ///< the same, and the name is local
    kIf,          ///< value, body, otherwise
    kWhile,       ///< value, body
    kBreak,
    kContinue,
    kReturn,  ///< value, or none
    kKill,    ///< value
    kJoin,    ///< value
    kHalt,
    kNothing
  };
  Kind kind = Kind::kNothing;
  int line = 1, column = 1;
  std::string target;
  std::vector<ExpressionPtr> indices;
  ExpressionPtr value;
  Block body, otherwise;
};

/// A script: what runs, and all functions and threads that are defined in it, wherever.
struct Script {
  std::string name;        ///< of the program
  bool secondary = false;  ///< a `sec` program: runs beside the main one
  bool bare = false;       ///< statements without a `def` around them
  Block body;
  std::vector<Function> functions;
};

/// Parses a whole program (`def name(): ... end`, `sec ...`), or single statements, which then are the program.
/// @return false and the first error. Realtime: setup.
[[nodiscard]] bool parse(std::string_view text, Script& script, ScriptError& error);
/// The same with all errors: after one it goes on with the next line. @return false if there are any
[[nodiscard]] bool parse(std::string_view text, Script& script, ScriptErrors& errors);
/// The script as a text that parses to the same, without its comments.
[[nodiscard]] std::string print(const Script& script);

}  // namespace takt::languages::urscript
