// Names, types and jumps.
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "languages/krl/builtins.h"
#include "languages/krl/lexer.h"
#include "languages/krl/program.h"
#include "languages/krl/type_table.h"

namespace takt::languages::krl {
namespace {

using Kind = Statement::Kind;
using OpCode = Instruction::Code;

struct LiveName {
  std::string_view name;
  Live live;
};
constexpr std::array<LiveName, 9> kLiveNames{{{"$IN", Live::kIn},
                                              {"$OUT", Live::kOut},
                                              {"$ANIN", Live::kAnalogIn},
                                              {"$ANOUT", Live::kAnalogOut},
                                              {"$POS_ACT", Live::kPosition},
                                              {"$AXIS_ACT", Live::kAxes},
                                              {"$TIMER", Live::kTimer},
                                              {"$TIMER_STOP", Live::kTimerStop},
                                              {"$CYCFLAG", Live::kCyclicFlag}}};

class Compiler {
 public:
  Compiler(Program& program, const std::set<std::string, std::less<>>& calls, Diagnostics& diagnostics)
      : program_(program), calls_(calls), diagnostics_(diagnostics), types_(program, diagnostics) {}

  void compile() {
    types_.declare();
    program_.variables.resize(program_.modules.size());
    for (std::size_t m = 0; m < program_.modules.size(); ++m) declare_data(static_cast<int>(m));
    for (std::size_t m = 0; m < program_.modules.size(); ++m) bind_initial(static_cast<int>(m));
    for (std::size_t m = 0; m < program_.modules.size(); ++m)
      for (const Function& one : program_.modules[m].functions) {
        CompiledFunction made;
        made.source = &one;
        made.module = static_cast<int>(m);
        program_.functions.push_back(std::move(made));
      }
    for (std::size_t f = 0; f < program_.functions.size(); ++f) function(f);
    const auto main = std::ranges::find(program_.functions, 0, &CompiledFunction::module);
    if (main == program_.functions.end()) {
      error({}, Code::kMissing, "there is no program", "Write DEF name ( ) ... END");
      return;
    }
    program_.main = static_cast<int>(main - program_.functions.begin());
    if (!main->source->parameters.empty())
      error(main->source->at, Code::kUnsupported, "the program that runs has parameters",
            "Write one that calls it with values");
  }

 private:
  void error(const TextLocation& at, Code code, std::string message, std::string hint) {
    const Module& module = program_.modules[static_cast<std::size_t>(module_)];
    error_at(diagnostics_, in_data_ ? module.data_file : module.file, at, code, std::move(message), std::move(hint));
  }

  // -- Variables -----------------------------------------------------------------------------------------------------

  static int find(const std::vector<Variable>& variables, std::string_view name) {
    const auto found = std::ranges::find(variables, name, &Variable::name);
    return found == variables.end() ? -1 : static_cast<int>(found - variables.begin());
  }

  void add(std::vector<Variable>& to, const Declaration& one) {
    if (find(to, one.name) >= 0)
      error(one.at, Code::kDuplicate, fmt::format("'{}' is declared twice", one.name), "Remove one of them");
    to.push_back({one.name, types_.find(one.type, one.at, module_, in_data_), types_.sizes(one), one.is_constant});
  }

  void declare_data(int m) {
    module_ = m;
    in_data_ = true;
    for (const Declaration& one : program_.modules[static_cast<std::size_t>(m)].data)
      add(program_.variables[static_cast<std::size_t>(m)], one);
    in_data_ = false;
  }

  void bind_initial(int m) {
    module_ = m;
    in_data_ = true;
    for (const Declaration& one : program_.modules[static_cast<std::size_t>(m)].data)
      for (const auto& [index, value] : one.initial) bind(*value);
    in_data_ = false;
    for (const Signal& one : program_.modules[static_cast<std::size_t>(m)].signals)
      if (one.last)
        error(one.at, Code::kUnsupported, fmt::format("'{}' is a group of signals", one.name), "Use single signals");
  }

  /// A variable of this module or one that all see. @return false: there is none
  bool find_shared(Expression& name) {
    for (std::size_t i = 0; i < program_.modules.size(); ++i) {
      const std::size_t m = i == 0 ? static_cast<std::size_t>(module_) : i - 1;
      const int slot = find(program_.variables[m], name.name);
      if (slot < 0) continue;
      const Module& module = program_.modules[m];
      const bool seen = static_cast<int>(m) == module_ || module.name.starts_with('$') ||
                        module.data[static_cast<std::size_t>(slot)].is_global;
      if (!seen) continue;
      name.where = Expression::Where::kModule;
      name.module = static_cast<int>(m);
      name.slot = slot;
      return true;
    }
    const std::size_t last = program_.modules.size() - 1;  // the prelude
    const int slot = find(program_.variables[last], name.name);
    if (slot < 0) return false;
    name.where = Expression::Where::kModule;
    name.module = static_cast<int>(last);
    name.slot = slot;
    return true;
  }

  const Signal* find_signal(const std::string& name) const {
    for (std::size_t i = 0; i <= program_.modules.size(); ++i) {
      const std::size_t m = i == 0 ? static_cast<std::size_t>(module_) : i - 1;
      const Module& module = program_.modules[m];
      if (i > 0 && !module.name.starts_with('$')) continue;
      const auto found = std::ranges::find(module.signals, name, &Signal::name);
      if (found != module.signals.end()) return &*found;
    }
    return nullptr;
  }

  // -- Expressions ---------------------------------------------------------------------------------------------------

  /// Binds the names of an expression. Calls of functions in it are made before, one after the other.
  /// @param calls  whether it may call functions of the program
  void bind(Expression& one, bool calls = true) {
    switch (one.kind) {
      case Expression::Kind::kName:
        return bind_name(one);
      case Expression::Kind::kIndex:
        return bind_index(one, calls);
      case Expression::Kind::kCall:
        return bind_call(one, calls);
      default:
        for (const ExpressionPtr& part : one.parts)
          if (part) bind(*part, calls);
    }
  }

  void bind_name(Expression& one) {
    if (function_ != nullptr) {
      one.slot = find(function_->locals, one.name);
      if (one.slot >= 0) {
        one.where = Expression::Where::kLocal;
        return;
      }
    }
    if (const Signal* signal = find_signal(one.name);
        signal != nullptr && signal->first->kind == Expression::Kind::kIndex) {
      one.kind = Expression::Kind::kIndex;
      one.parts.push_back(copy(*signal->first->parts[0]));
      one.parts.push_back(copy(*signal->first->parts[1]));
      return bind_index(one, false);
    }
    const auto live = std::ranges::find(kLiveNames, one.name, &LiveName::name);
    if (live != kLiveNames.end()) {
      one.where = Expression::Where::kLive;
      one.live = static_cast<int>(live->live);
      stops_ = stops_ || live->live != Live::kCyclicFlag;
      return;
    }
    if (find_shared(one)) return;
    std::vector<std::string> names;
    if (function_ != nullptr)
      for (const Variable& known : function_->locals)
        if (!known.name.starts_with(' ')) names.push_back(known.name);
    for (const std::size_t m : {static_cast<std::size_t>(module_), program_.modules.size() - 1})
      for (const Variable& known : program_.variables[m]) names.push_back(known.name);
    error(one.at, Code::kUnknownName, fmt::format("there is no variable '{}'", one.name),
          nearest_choice(one.name, names, 3));
  }

  void bind_index(Expression& one, bool calls) {
    for (const ExpressionPtr& part : one.parts) bind(*part, calls);
    const Expression& array = *one.parts[0];
    if (array.where != Expression::Where::kLive || one.parts.size() != 2) return;
    const auto live = static_cast<Live>(array.live);
    const bool is_signal =
        live == Live::kIn || live == Live::kOut || live == Live::kAnalogIn || live == Live::kAnalogOut;
    const Expression& index = *one.parts[1];
    if (!is_signal || index.kind != Expression::Kind::kLiteral || index.value.kind != Value::Kind::kInt) return;
    program_.signals.push_back({live, index.value.integer, module_, one.at, writes_});
  }

  int find_function(const std::string& name) const {
    for (std::size_t f = 0; f < program_.functions.size(); ++f)
      if (program_.functions[f].module == module_ && program_.functions[f].source->name == name)
        return static_cast<int>(f);
    for (std::size_t f = 0; f < program_.functions.size(); ++f) {
      const CompiledFunction& one = program_.functions[f];
      const Module& module = program_.modules[static_cast<std::size_t>(one.module)];
      const bool is_first = one.source == &module.functions.front();
      if (one.source->name == name && (one.source->is_global || is_first)) return static_cast<int>(f);
    }
    return -1;
  }

  void bind_call(Expression& one, bool calls) {
    for (const ExpressionPtr& part : one.parts)
      if (part) bind(*part, calls);
    if (find_builtin(one.name) != nullptr) {
      one.where = Expression::Where::kBuiltin;
      check_builtin(one);
      return;
    }
    const int target = find_function(one.name);
    if (target < 0) return unknown_call(one);
    check_arguments(one, *program_.functions[static_cast<std::size_t>(target)].source);
    one.where = Expression::Where::kFunction;
    if (!calls || function_ == nullptr) {
      error(one.at, Code::kUnsupported, fmt::format("a call of '{}' here", one.name),
            "Assign its result to a variable before");
      return;
    }
    if (program_.functions[static_cast<std::size_t>(target)].source->result.empty())
      error(one.at, Code::kWrongType, fmt::format("'{}' has no result", one.name), "Write DEFFCT TYPE name");
    one.slot = temporary();
    const bool stops = stops_;
    emit({.code = OpCode::kCall, .a = &one, .x = target, .y = one.slot});
    stops_ = stops;  // what the expression asks besides is asked after the call
  }

  void check_builtin(const Expression& one) {
    const Builtin& builtin = *find_builtin(one.name);
    if (one.parts.size() != builtin.arguments ||
        std::ranges::any_of(one.parts, [](const ExpressionPtr& part) { return part == nullptr; }))
      error(one.at, Code::kWrongSize, fmt::format("'{}' with {} arguments", one.name, one.parts.size()),
            fmt::format("Give {}", builtin.arguments));
  }

  void check_arguments(const Expression& call, const Function& function) {
    if (call.parts.size() > function.parameters.size())
      error(call.at, Code::kWrongSize,
            fmt::format("'{}' has {} parameters, not {}", function.name, function.parameters.size(), call.parts.size()),
            "Remove what is too much");
    for (std::size_t i = 0; i < std::min(call.parts.size(), function.parameters.size()); ++i) {
      if (!call.parts[i]) continue;
      const Expression::Kind kind = call.parts[i]->kind;
      const bool is_place =
          kind == Expression::Kind::kName || kind == Expression::Kind::kField || kind == Expression::Kind::kIndex;
      if (function.parameters[i].is_out && !is_place && call.parts[i]->kind != Expression::Kind::kLiteral)
        error(call.parts[i]->at, Code::kWrongType,
              fmt::format("parameter '{}' of '{}' is OUT", function.parameters[i].name, function.name),
              "Give a variable");
    }
  }

  void unknown_call(const Expression& one) {
    std::vector<std::string> names(calls_.begin(), calls_.end());
    for (const CompiledFunction& known : program_.functions) names.push_back(known.source->name);
    error(one.at, Code::kUnknownName, fmt::format("there is no program '{}'", one.name),
          nearest_choice(one.name, names, 5));
  }

  // -- Statements ----------------------------------------------------------------------------------------------------

  int temporary() {
    function_->locals.push_back({fmt::format(" {}", function_->locals.size()), {}, {}, false});
    return static_cast<int>(function_->locals.size()) - 1;
  }

  int emit(Instruction one) {
    one.stops = std::exchange(stops_, false);
    program_.code.push_back(one);
    return static_cast<int>(program_.code.size()) - 1;
  }
  [[nodiscard]] int here() const { return static_cast<int>(program_.code.size()); }
  void aim(int jump, int target) { program_.code[static_cast<std::size_t>(jump)].x = target; }

  void function(std::size_t f) {
    function_ = &program_.functions[f];
    module_ = function_->module;
    const Function& source = *function_->source;
    function_->begin = program_.code.size();
    if (!source.result.empty()) function_->result = types_.find(source.result, source.at, module_, false);
    for (const Parameter& one : source.parameters) {
      const auto declared = std::ranges::find(source.declarations, one.name, &Declaration::name);
      if (declared == source.declarations.end()) {
        error(one.at, Code::kMissing, fmt::format("the parameter '{}' has no type", one.name),
              fmt::format("Write DECL TYPE {}", one.name));
        function_->locals.push_back({one.name, {}, {}, false});
      } else {
        add(function_->locals, *declared);
      }
    }
    for (const Declaration& one : source.declarations)
      if (std::ranges::find(source.parameters, one.name, &Parameter::name) == source.parameters.end())
        add(function_->locals, one);
    for (const Declaration& one : source.declarations)
      for (const auto& [index, value] : one.initial) {
        bind(*value);
        emit({.code = OpCode::kSet, .a = value.get(), .x = find(function_->locals, one.name)});
      }
    labels_.clear();
    jumps_.clear();
    exits_.clear();
    block(source.body);
    emit({.code = OpCode::kReturn});
    for (const auto& [at, statement] : jumps_) {
      const auto label = labels_.find(statement->word);
      if (label == labels_.end())
        error(statement->at, Code::kUnknownName, fmt::format("there is no label '{}' here", statement->word),
              "Write the label in the same program");
      else
        retarget(at, label->second);
    }
    function_ = nullptr;
  }

  void retarget(int jump, int target) {
    aim(jump, target);
    if (target <= jump) program_.code[static_cast<std::size_t>(jump)].code = OpCode::kJumpBack;
  }

  void block(const Block& statements) {
    for (const Statement& one : statements) statement(one);
  }

  void loop_body(const Statement& one) {
    exits_.emplace_back();
    block(one.body);
  }
  void end_loop() {
    for (const int jump : exits_.back()) aim(jump, here());
    exits_.pop_back();
  }

  void statement(const Statement& one) {
    switch (one.kind) {
      case Kind::kIf:
        return if_statement(one);
      case Kind::kLoop:
      case Kind::kWhile:
      case Kind::kRepeat:
        return loop(one);
      case Kind::kFor:
        return for_loop(one);
      case Kind::kSwitch:
        return selection(one);
      case Kind::kGoto: {
        jumps_.emplace_back(emit({.code = OpCode::kJump, .statement = &one}), &one);
        return;
      }
      case Kind::kLabel:
        if (!labels_.emplace(one.word, here()).second)
          error(one.at, Code::kDuplicate, fmt::format("there are two labels '{}'", one.word), "Rename one of them");
        return;
      case Kind::kExit:
        if (exits_.empty()) {
          error(one.at, Code::kSyntax, "EXIT outside of a loop", "Use RETURN");
        } else {
          exits_.back().push_back(emit({.code = OpCode::kJump, .statement = &one}));
        }
        return;
      case Kind::kReturn:
        if (one.a) bind(*one.a);
        emit({.code = OpCode::kReturn, .statement = &one, .a = one.a.get()});
        return;
      case Kind::kCall:
        return call(one);
      default:
        return execute(one);
    }
  }

  void call(const Statement& one) {
    if (one.a->kind != Expression::Kind::kCall) return;
    if (calls_.contains(one.a->name)) {
      for (const ExpressionPtr& part : one.a->parts)
        if (part) bind(*part);
      one.a->where = Expression::Where::kBuiltin;
      stops_ = true;
      emit({.code = OpCode::kExecute, .statement = &one});
      return;
    }
    for (const ExpressionPtr& part : one.a->parts)
      if (part) bind(*part);
    const int target = find_function(one.a->name);
    if (target < 0) return unknown_call(*one.a);
    check_arguments(*one.a, *program_.functions[static_cast<std::size_t>(target)].source);
    emit({.code = OpCode::kCall, .statement = &one, .a = one.a.get(), .x = target});
  }

  void if_statement(const Statement& one) {
    bind(*one.a);
    const int no = emit({.code = OpCode::kJumpIfFalse, .statement = &one, .a = one.a.get()});
    block(one.body);
    if (one.otherwise.empty()) return aim(no, here());
    const int over = emit({.code = OpCode::kJump, .statement = &one});
    aim(no, here());
    block(one.otherwise);
    aim(over, here());
  }

  void loop(const Statement& one) {
    const int begin = here();
    int end = -1;
    if (one.kind == Kind::kWhile) {
      bind(*one.a);
      end = emit({.code = OpCode::kJumpIfFalse, .statement = &one, .a = one.a.get()});
    }
    loop_body(one);
    if (one.kind == Kind::kRepeat) {
      bind(*one.a);
      const int test = emit({.code = OpCode::kJumpIfFalse, .statement = &one, .a = one.a.get()});
      const int leave = emit({.code = OpCode::kJump, .statement = &one});
      aim(test, here());
      emit({.code = OpCode::kJumpBack, .statement = &one, .x = begin});
      aim(leave, here());
    } else {
      emit({.code = OpCode::kJumpBack, .statement = &one, .x = begin});
    }
    if (end >= 0) aim(end, here());
    end_loop();
  }

  void for_loop(const Statement& one) {
    const int limit = temporary();
    const int step = temporary();
    bind(*one.a);
    bind(*one.b);
    bind(*one.c);
    if (one.d) bind(*one.d);
    emit({.code = OpCode::kSet, .statement = &one, .a = one.c.get(), .x = limit});
    emit({.code = OpCode::kSet, .statement = &one, .a = one.d.get(), .x = step});
    emit({.code = OpCode::kExecute, .statement = &one});
    const int test = emit({.code = OpCode::kForTest, .statement = &one, .a = one.a.get(), .y = limit});
    loop_body(one);
    emit({.code = OpCode::kForStep, .statement = &one, .a = one.a.get(), .y = limit});
    emit({.code = OpCode::kJumpBack, .statement = &one, .x = test});
    aim(test, here());
    end_loop();
  }

  void selection(const Statement& one) {
    const int value = temporary();
    bind(*one.a);
    emit({.code = OpCode::kSet, .statement = &one, .a = one.a.get(), .x = value});
    std::vector<std::vector<int>> begins;
    const Case* fallback = nullptr;
    for (const Case& each : one.cases) {
      begins.emplace_back();
      if (each.labels.empty()) fallback = &each;
      for (const ExpressionPtr& label : each.labels) {
        bind(*label);
        begins.back().push_back(emit({.code = OpCode::kCase, .statement = &one, .a = label.get(), .y = value}));
      }
    }
    std::vector<int> ends;
    if (fallback != nullptr) block(fallback->body);
    ends.push_back(emit({.code = OpCode::kJump, .statement = &one}));
    for (std::size_t i = 0; i < one.cases.size(); ++i) {
      if (&one.cases[i] == fallback) continue;
      for (const int jump : begins[i]) aim(jump, here());
      block(one.cases[i].body);
      ends.push_back(emit({.code = OpCode::kJump, .statement = &one}));
    }
    for (const int jump : ends) aim(jump, here());
  }

  void execute(const Statement& one) {
    const bool inside = one.kind == Kind::kTrigger || one.kind == Kind::kInterruptDeclare;
    bind_parts(one, !inside);
    if (one.kind == Kind::kAssign) check_target(one);
    switch (one.kind) {
      case Kind::kWaitSeconds:
      case Kind::kWaitFor:
      case Kind::kHalt:
      case Kind::kPulse:
      case Kind::kInterruptSwitch:
        stops_ = true;
        break;
      case Kind::kTrigger:
      case Kind::kInterruptDeclare:
        stops_ = false;
        break;
      default:
        break;
    }
    emit({.code = OpCode::kExecute, .statement = &one});
  }

  void bind_parts(const Statement& one, bool calls) {
    writes_ = one.kind == Kind::kAssign || one.kind == Kind::kPulse;
    if (one.a) bind(*one.a, calls && one.kind != Kind::kWaitFor);
    writes_ = false;
    if (one.b) bind(*one.b, calls);
    if (one.kind == Kind::kInterruptDeclare) {
      bind_interrupt(*one.c);
      if (one.flag) refuse_locals(one.b.get(), "a global interrupt");
      for (const ExpressionPtr& part : one.c->parts)
        if (one.flag) refuse_locals(part.get(), "a global interrupt");
    } else if (one.c) {
      bind(*one.c, calls);
    }
    for (const ExpressionPtr& goal : one.goals)
      if (goal) bind(*goal, calls);
    for (const auto& [target, value] : one.with) {
      bind(*target, calls);
      bind(*value, calls);
    }
    if (one.kind == Kind::kTrigger && !one.body.empty()) bind_trigger(one.body.front());
    if (one.kind == Kind::kSpline)
      for (const Statement& segment : one.body) bind_parts(segment, calls);
  }

  /// A trigger acts in the cycle, so it can do what a handler of a transaction can.
  void bind_trigger(const Statement& action) {
    if (action.kind == Kind::kCall)
      return error(action.at, Code::kUnsupported, "a trigger that calls a program",
                   "Write $OUT, $ANOUT or PULSE; call the program before or behind the motion");
    bind_parts(action, false);
    if (action.kind == Kind::kPulse) return;
    check_target(action);
    const Expression* root = action.a->kind == Expression::Kind::kIndex ? action.a->parts[0].get() : action.a.get();
    const auto live = static_cast<Live>(root->live);
    if (root->where != Expression::Where::kLive || (live != Live::kOut && live != Live::kAnalogOut))
      error(action.at, Code::kUnsupported, "a trigger that assigns no output", "Write $OUT, $ANOUT or PULSE");
  }

  /// It is evaluated while other programs run, too.
  void refuse_locals(const Expression* one, std::string_view where) {
    if (one == nullptr) return;
    if (one->where == Expression::Where::kLocal || one->where == Expression::Where::kFunction)
      error(one->at, Code::kUnsupported, fmt::format("'{}' of this program in {}", one->name, where),
            "Use variables of the data list");
    for (const ExpressionPtr& part : one->parts) refuse_locals(part.get(), where);
  }

  void bind_interrupt(Expression& call) {
    if (call.kind != Expression::Kind::kCall) return;
    for (const ExpressionPtr& part : call.parts)
      if (part) bind(*part, false);
    call.slot = find_function(call.name);
    call.where = Expression::Where::kFunction;
    if (call.slot < 0) return unknown_call(call);
    check_arguments(call, *program_.functions[static_cast<std::size_t>(call.slot)].source);
  }

  void check_target(const Statement& one) {
    const Expression* root = one.a.get();
    while (root->kind == Expression::Kind::kField || root->kind == Expression::Kind::kIndex)
      root = root->parts[0].get();
    if (root->kind != Expression::Kind::kName)
      return error(one.at, Code::kSyntax, "what cannot be assigned", "Write a variable");
    const bool is_local = root->where == Expression::Where::kLocal;
    const Variable* variable = nullptr;
    if (is_local) variable = &function_->locals[static_cast<std::size_t>(root->slot)];
    if (root->where == Expression::Where::kModule)
      variable = &program_.variables[static_cast<std::size_t>(root->module)][static_cast<std::size_t>(root->slot)];
    if (root->where == Expression::Where::kLive && static_cast<Live>(root->live) == Live::kCyclicFlag)
      refuse_locals(one.b.get(), "a cyclic flag");
    const auto live = static_cast<Live>(root->live);
    const bool reads_only = root->where == Expression::Where::kLive && (live == Live::kIn || live == Live::kAnalogIn ||
                                                                        live == Live::kPosition || live == Live::kAxes);
    if (reads_only || (variable != nullptr && variable->is_constant))
      error(one.at, Code::kConflict, fmt::format("'{}' cannot be written", root->name), "Assign another variable");
  }

  Program& program_;
  const std::set<std::string, std::less<>>& calls_;
  Diagnostics& diagnostics_;
  TypeTable types_;
  CompiledFunction* function_ = nullptr;
  int module_ = 0;
  bool in_data_ = false, stops_ = false, writes_ = false;
  std::map<std::string, int, std::less<>> labels_;
  std::vector<std::pair<int, const Statement*>> jumps_;
  std::vector<std::vector<int>> exits_;
};

}  // namespace

Result<std::shared_ptr<const Program>> compile(const std::vector<ModuleText>& modules,
                                               const std::set<std::string, std::less<>>& calls) {
  Diagnostics diagnostics;
  auto program = std::make_shared<Program>();
  for (const ModuleText& one : modules) program->modules.push_back(parse_module(one, diagnostics));
  program->modules.push_back(parse_module(prelude(), diagnostics));
  if (!diagnostics.has_errors()) Compiler(*program, calls, diagnostics).compile();
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return std::shared_ptr<const Program>(std::move(program));
}

}  // namespace takt::languages::krl
