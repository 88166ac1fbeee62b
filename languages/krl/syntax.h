#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/text_location.h"
#include "languages/krl/value.h"

/// A module (.src with its .dat) as a tree. Names are in capitals.
namespace takt::languages::krl {

struct Expression;
using ExpressionPtr = std::unique_ptr<Expression>;

enum class Operator : std::uint8_t {
  kNone,
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kGeometric,
  kEqual,
  kNotEqual,
  kLess,
  kLessEqual,
  kGreater,
  kGreaterEqual,
  kAnd,
  kOr,
  kExor,
  kNot,
  kNegate,
  kBitAnd,
  kBitOr,
  kBitExor,
  kBitNot
};

struct Expression {
  enum class Kind : std::uint8_t {
    kLiteral,    ///< value
    kName,       ///< name
    kField,      ///< parts[0] . name
    kIndex,      ///< parts[0] [ parts[1...] ]; without an index: the whole array
    kCall,       ///< name ( parts ); a part may be null: it was left out
    kUnary,      ///< op parts[0]
    kBinary,     ///< parts[0] op parts[1]
    kAggregate,  ///< {name: names[i] parts[i]}; name may be empty
  };
  Kind kind = Kind::kLiteral;
  TextLocation at;
  std::string name;
  Value value;
  Operator op = Operator::kNone;
  std::vector<ExpressionPtr> parts;
  std::vector<std::string> names;

  // Filled in by the compiler.
  enum class Where : std::uint8_t { kNowhere, kLocal, kModule, kLive, kFunction, kBuiltin };
  Where where = Where::kNowhere;
  int slot = -1;    ///< of a variable; of a call of a function its result, among the locals
  int module = -1;  ///< of a variable of a module
  int live = -1;    ///< of a variable of the machine: which
};

struct Statement;
using Block = std::vector<Statement>;

/// A case of SWITCH; the one without labels is DEFAULT.
struct Case {
  std::vector<ExpressionPtr> labels;
  Block body;
};

struct Statement {
  enum class Kind : std::uint8_t {
    kAssign,  ///< a = b
    kCall,    ///< a
    kIf,      ///< a; body, otherwise
    kLoop,    ///< body
    kWhile,   ///< a, body
    kRepeat,  ///< body, a
    kFor,     ///< a = b TO c STEP d; body
    kSwitch,  ///< a; cases
    kGoto,    ///< word
    kLabel,   ///< word
    kExit,
    kReturn,  ///< a may be null
    kHalt,
    kContinue,
    kWaitSeconds,       ///< a
    kWaitFor,           ///< a
    kMotion,            ///< word PTP, LIN, ...; goals, approximation, with; c: CA
    kSpline,            ///< body: segments and triggers; approximation, with
    kTrigger,           ///< word DISTANCE or PATH; a, ONSTART: flag; b DELAY; body: one statement; c PRIO
    kInterruptDeclare,  ///< a number, b condition, c call; flag: GLOBAL
    kInterruptSwitch,   ///< word ON, OFF, ENABLE, DISABLE; a number or null: all
    kBrake,             ///< flag: F
    kResume,
    kPulse,  ///< a output, b level, c time
  };
  Kind kind = Kind::kHalt;
  TextLocation at;
  std::string text;  ///< as it was written, for people
  std::string word;
  bool flag = false;
  ExpressionPtr a, b, c, d;
  Block body, otherwise;
  std::vector<Case> cases;
  std::vector<ExpressionPtr> goals;                           ///< of a motion; of CIRC the point on the way first
  std::vector<std::string> approximation;                     ///< C_PTP, C_DIS, ...
  std::vector<std::pair<ExpressionPtr, ExpressionPtr>> with;  ///< WITH target = value, ...
};

struct Declaration {
  std::string name, type;
  TextLocation at;
  std::vector<ExpressionPtr> size;
  std::vector<std::pair<std::vector<int>, ExpressionPtr>> initial;  ///< of an element, or with no index of the whole
  bool is_global = false, is_constant = false;
};

struct TypeDeclaration {
  std::string name;
  TextLocation at;
  bool is_enumeration = false;
  std::vector<std::string> constants;
  std::vector<Declaration> fields;
};

/// SIGNAL name $OUT[n], or TO $OUT[m].
struct Signal {
  std::string name;
  TextLocation at;
  ExpressionPtr first, last;
};

struct Parameter {
  std::string name;
  bool is_out = false;
  bool is_array = false;
  TextLocation at;
};

struct Function {
  std::string name, result;  ///< result: of DEFFCT, else empty
  TextLocation at;
  bool is_global = false;
  std::vector<Parameter> parameters;
  std::vector<Declaration> declarations;
  Block body;
};

struct Module {
  std::string name, file, data_file;
  std::vector<Declaration> data;
  std::vector<TypeDeclaration> types;
  std::vector<Signal> signals;
  std::vector<Function> functions;  ///< the first one is what others call by the name of the module
};

}  // namespace takt::languages::krl
