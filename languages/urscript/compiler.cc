#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "languages/urscript/program.h"

namespace takt::languages::urscript {

namespace {

using Code = Instruction::Code;

/// Thrown inside of the compiler only.
struct NotCompiled {
  ScriptError error;
};

/// All names that a block assigns, with those of its branches: for the three kinds of assignment.
struct Assigned {
  std::set<std::string> plain, global, local;

  void look_at(const Block& block) {
    for (const Statement& statement : block) {
      if (statement.kind == Statement::Kind::kAssign) plain.insert(statement.target);
      if (statement.kind == Statement::Kind::kGlobal) global.insert(statement.target);
      if (statement.kind == Statement::Kind::kLocal) local.insert(statement.target);
      look_at(statement.body);
      look_at(statement.otherwise);
    }
  }
};

class Compiler {
 public:
  Compiler(const Script& script, const Library& library, ScriptErrors& errors)
      : script_(script), library_(library), errors_(errors) {}

  /// @return null with errors
  std::shared_ptr<const Program> run(std::span<const std::string> given) {
    for (const std::string& name : given) globals_.emplace(name, static_cast<int>(globals_.size()));
    program_.name = script_.name;
    program_.secondary = script_.secondary;
    find_globals();
    name_functions();
    compile_function(0, {}, script_.body);
    for (std::size_t i = 0; i < script_.functions.size(); ++i)
      compile_function(i + 1, script_.functions[i].parameters, script_.functions[i].body);
    program_.globals = static_cast<int>(globals_.size());
    if (!errors_.empty()) return nullptr;
    return std::make_shared<const Program>(std::move(program_));
  }

 private:
  using Slots = std::map<std::string, int, std::less<>>;

  [[noreturn]] static void refuse(int line, int column, std::string text) {
    throw NotCompiled{{line, column, std::move(text)}};
  }

  void find_globals() {
    Assigned main;
    main.look_at(script_.body);
    for (const auto* names : {&main.plain, &main.global})
      for (const std::string& name : *names)
        if (!main.local.contains(name)) globals_.emplace(name, static_cast<int>(globals_.size()));
    for (const Function& function : script_.functions) {
      Assigned inner;
      inner.look_at(function.body);
      for (const std::string& name : inner.global) globals_.emplace(name, static_cast<int>(globals_.size()));
    }
  }
  void name_functions() {
    program_.functions.push_back({.name = script_.name});
    for (const Function& function : script_.functions) {
      functions_[function.name] = static_cast<int>(program_.functions.size());
      program_.functions.push_back({.name = function.name, .parameters = static_cast<int>(function.parameters.size())});
    }
  }

  void compile_function(std::size_t number, const std::vector<Parameter>& parameters, const Block& body) {
    locals_.clear();
    for (const Parameter& parameter : parameters) (void)local(parameter.name);
    Assigned assigned;
    assigned.look_at(body);
    for (const std::string& name : assigned.local) (void)local(name);
    for (const std::string& name : assigned.plain)
      if (!globals_.contains(name)) (void)local(name);
    program_.functions[number].begin = program_.code.size();
    in_main_ = number == 0;
    depth_ = 0;
    compile(body);
    emit(Code::kConstant, constant({}));
    emit(Code::kReturn);
    program_.functions[number].locals = static_cast<int>(locals_.size());
  }
  int local(const std::string& name) { return locals_.emplace(name, static_cast<int>(locals_.size())).first->second; }

  // -- Code ----------------------------------------------------------------------------------------------------------
  std::size_t emit(Code code, int a = 0, int b = 0) {
    if (program_.code.size() >= kLongest) refuse(line_, 1, "the program is too long");
    program_.code.push_back({code, a, b, line_, column_});
    return program_.code.size() - 1;
  }
  int constant(Value value) {
    program_.constants.push_back(std::move(value));
    return static_cast<int>(program_.constants.size()) - 1;
  }
  [[nodiscard]] int here() const { return static_cast<int>(program_.code.size()); }
  void land(std::size_t jump) { program_.code[jump].a = here(); }
  void land_all(const std::vector<std::size_t>& jumps) {
    for (const std::size_t jump : jumps) land(jump);
  }

  // -- Statements ----------------------------------------------------------------------------------------------------
  void compile(const Block& block) {
    for (const Statement& statement : block) {
      try {
        compile_noted(statement);
      } catch (NotCompiled& refused) {
        if (errors_.size() >= kMostErrors) return;
        errors_.push_back(std::move(refused.error));
      }
    }
  }
  /// Of the main program it is written down where each statement is.
  void compile_noted(const Statement& statement) {
    if (!in_main_) return compile(statement);
    const std::size_t number = program_.statements.size(), begin = program_.code.size();
    const bool top = depth_ == 0;
    program_.statements.push_back({statement.line, begin, begin});
    ++depth_;
    compile(statement);
    --depth_;
    MainStatement& noted = program_.statements[number];
    noted.end = program_.code.size();
    const bool assigns = statement.kind == Statement::Kind::kAssign || statement.kind == Statement::Kind::kGlobal;
    noted.assigns = top && assigns && statement.value != nullptr && is_pure(*statement.value) &&
                    std::ranges::all_of(statement.indices, [&](const ExpressionPtr& one) { return is_pure(*one); });
  }
  [[nodiscard]] bool is_pure(const Expression& one) const {
    if (one.kind == Expression::Kind::kRun) return false;
    if (one.kind == Expression::Kind::kCall) {
      const int builtin = functions_.contains(one.name) ? -1 : library_.find(one.name);
      if (builtin < 0 || !library_.all()[static_cast<std::size_t>(builtin)].pure) return false;
    }
    return std::ranges::all_of(one.parts, [&](const ExpressionPtr& part) { return is_pure(*part); }) &&
           std::ranges::all_of(one.arguments, [&](const Argument& argument) { return is_pure(*argument.value); });
  }
  void compile(const Statement& statement) {
    using Kind = Statement::Kind;
    line_ = statement.line;
    column_ = statement.column;
    switch (statement.kind) {
      case Kind::kExpression:
        compile(*statement.value);
        emit(Code::kPop);
        return;
      case Kind::kAssign:
      case Kind::kGlobal:
      case Kind::kLocal:
        return compile_assignment(statement);
      case Kind::kIf:
        return compile_if(statement);
      case Kind::kWhile:
        return compile_while(statement);
      case Kind::kBreak:
      case Kind::kContinue:
        return compile_leap(statement);
      case Kind::kReturn:
        return compile_return(statement);
      case Kind::kKill:
      case Kind::kJoin:
        compile(*statement.value);
        emit(statement.kind == Kind::kKill ? Code::kKill : Code::kJoin);
        return;
      case Kind::kHalt:
        emit(Code::kHalt);
        return;
      case Kind::kNothing:
        return;
    }
  }
  void compile_assignment(const Statement& statement) {
    if (statement.value == nullptr) {
      emit(Code::kConstant, constant({}));
    } else {
      for (const ExpressionPtr& index : statement.indices) compile(*index);
      compile(*statement.value);
    }
    const auto slot = locals_.find(statement.target);
    const bool is_local = slot != locals_.end() && statement.kind != Statement::Kind::kGlobal;
    const int to = is_local ? slot->second : globals_.at(statement.target);
    if (statement.indices.empty()) {
      emit(is_local ? Code::kStoreLocal : Code::kStoreGlobal, to);
    } else {
      emit(is_local ? Code::kStoreLocalAt : Code::kStoreGlobalAt, to, static_cast<int>(statement.indices.size()));
    }
  }
  void compile_if(const Statement& statement) {
    compile(*statement.value);
    const std::size_t over = emit(Code::kJumpIfFalse);
    compile(statement.body);
    if (statement.otherwise.empty()) return land(over);
    const std::size_t to_end = emit(Code::kJump);
    land(over);
    compile(statement.otherwise);
    land(to_end);
  }
  void compile_while(const Statement& statement) {
    const int begin = here();
    compile(*statement.value);
    const std::size_t out = emit(Code::kJumpIfFalse);
    loops_.push_back({begin, {}});
    compile(statement.body);
    emit(Code::kJumpBack, begin);
    land(out);
    land_all(loops_.back().breaks);
    loops_.pop_back();
  }
  void compile_leap(const Statement& statement) {
    const bool leaves = statement.kind == Statement::Kind::kBreak;
    if (loops_.empty())
      refuse(statement.line, statement.column, fmt::format("'{}' outside of a loop", leaves ? "break" : "continue"));
    if (leaves) {
      loops_.back().breaks.push_back(emit(Code::kJump));
    } else {
      emit(Code::kJumpBack, loops_.back().begin);
    }
  }
  void compile_return(const Statement& statement) {
    if (statement.value != nullptr) {
      compile(*statement.value);
    } else {
      emit(Code::kConstant, constant({}));
    }
    emit(Code::kReturn);
  }

  // -- Expressions ---------------------------------------------------------------------------------------------------
  void compile(const Expression& expression) {
    using Kind = Expression::Kind;
    switch (expression.kind) {
      case Kind::kConstant:
        emit(Code::kConstant, constant(expression.value));
        return;
      case Kind::kName:
        return compile_name(expression);
      case Kind::kList:
        compile_parts(expression);
        emit(Code::kList, static_cast<int>(expression.parts.size()));
        return;
      case Kind::kPose:
        compile_parts(expression);
        emit(Code::kPose);
        return;
      case Kind::kIndex:
        compile_parts(expression);
        emit(Code::kIndex, static_cast<int>(expression.parts.size()) - 1);
        return;
      case Kind::kCall:
      case Kind::kRun:
        return compile_call(expression);
      case Kind::kNegate:
      case Kind::kNot:
        compile_parts(expression);
        emit(expression.kind == Kind::kNot ? Code::kNot : Code::kNegate);
        return;
      case Kind::kOperator:
        return compile_operator(expression);
    }
  }
  void compile_parts(const Expression& expression) {
    for (const ExpressionPtr& part : expression.parts) compile(*part);
  }
  void compile_name(const Expression& expression) {
    if (const auto slot = locals_.find(expression.name); slot != locals_.end()) {
      emit(Code::kLoadLocal, slot->second);
    } else if (const auto global = globals_.find(expression.name); global != globals_.end()) {
      emit(Code::kLoadGlobal, global->second);
    } else {
      refuse_name(expression);
    }
  }
  [[noreturn]] static void refuse_name(const Expression& expression) {
    const bool is_call = expression.kind != Expression::Kind::kName;
    throw NotCompiled{{expression.line, expression.column,
                       fmt::format("compile_error_name_not_found:{}:", expression.name), expression.name, is_call}};
  }
  void compile_operator(const Expression& expression) {
    const bool is_and = expression.op == Operator::kAnd, is_or = expression.op == Operator::kOr;
    compile(*expression.parts[0]);
    const std::size_t over = is_and || is_or ? emit(is_and ? Code::kShortAnd : Code::kShortOr) : 0;
    compile(*expression.parts[1]);
    if (is_and || is_or) {
      land(over);
    } else {
      emit(Code::kOperator, static_cast<int>(expression.op));
    }
  }

  void compile_call(const Expression& call) {
    const auto function = functions_.find(call.name);
    if (function != functions_.end()) {
      const auto& parameters = script_.functions[static_cast<std::size_t>(function->second) - 1].parameters;
      compile_arguments(call, parameters, false);
      const bool runs = call.kind == Expression::Kind::kRun;
      line_ = call.line;
      column_ = call.column;
      emit(runs ? Code::kRun : Code::kCall, function->second, static_cast<int>(parameters.size()));
      return;
    }
    const int builtin = library_.find(call.name);
    if (builtin < 0 || call.kind == Expression::Kind::kRun) refuse_name(call);
    const Builtin& known = library_.all()[static_cast<std::size_t>(builtin)];
    const int count = compile_arguments(call, known.parameters, known.repeats);
    BuiltinCall& use = program_.calls.emplace_back(call.name, std::nullopt, call.line, call.column);
    if (!call.arguments.empty() && call.arguments.front().value->kind == Expression::Kind::kConstant)
      use.first = call.arguments.front().value->value;
    line_ = call.line;
    column_ = call.column;
    emit(Code::kBuiltin, builtin, count);
  }
  /// In the order of the parameters; what is missing becomes its default. @return how many
  int compile_arguments(const Expression& call, const std::vector<Parameter>& parameters, bool repeats) {
    std::vector<const Expression*> given(parameters.size(), nullptr);
    std::size_t next = 0;
    for (const Argument& argument : call.arguments) {
      const std::size_t at = argument.name.empty() ? next++ : place_of(argument.name, parameters, call);
      if (at >= given.size() && !repeats)
        refuse(call.line, call.column, fmt::format("'{}' has {} parameters", call.name, parameters.size()));
      if (at >= given.size()) given.resize(at + 1, nullptr);
      given[at] = argument.value.get();
    }
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (given[i] != nullptr) {
        compile(*given[i]);
      } else if (parameters[i].fallback) {
        emit(Code::kConstant, constant(*parameters[i].fallback));
      } else {
        refuse(call.line, call.column, fmt::format("'{}' needs its parameter '{}'", call.name, parameters[i].name));
      }
    }
    return static_cast<int>(given.size());
  }
  static std::size_t place_of(const std::string& name, const std::vector<Parameter>& parameters,
                              const Expression& call) {
    const auto at = std::ranges::find_if(
        parameters, [&](const Parameter& one) { return one.name == name || one.other_name == name; });
    if (at == parameters.end())
      refuse(call.line, call.column, fmt::format("'{}' has no parameter '{}'", call.name, name));
    return static_cast<std::size_t>(at - parameters.begin());
  }

  static constexpr std::size_t kLongest = 1u << 20;  // instructions
  struct Loop {
    int begin = 0;
    std::vector<std::size_t> breaks;
  };

  const Script& script_;
  const Library& library_;
  ScriptErrors& errors_;
  Program program_;
  Slots globals_, locals_, functions_;
  std::vector<Loop> loops_;
  int line_ = 1, column_ = 1;
  bool in_main_ = false;
  int depth_ = 0;  ///< of blocks in the main program
};

/// A default in a signature.
Value default_value(std::string_view text) {
  if (text == "True" || text == "False") return text == "True";
  if (text == "None") return {};
  std::vector<Token> tokens;
  ScriptError error;
  const bool minus = text.starts_with('-');
  (void)tokenize(text.substr(minus ? 1 : 0), tokens, error);
  const Token& token = tokens.front();
  const Value value = token.kind == Token::Kind::kString ? Value(token.text) : token.value;
  return minus ? negated(value).value_or(value) : value;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

/// "a", "a|b", "a=1".
Parameter read_parameter(std::string_view entry) {
  Parameter read;
  const std::size_t equals = entry.find('=');
  if (equals != std::string_view::npos) read.fallback = default_value(entry.substr(equals + 1));
  const std::string_view names = entry.substr(0, equals);
  const std::size_t bar = names.find('|');
  read.name = names.substr(0, bar);
  if (bar != std::string_view::npos) read.other_name = names.substr(bar + 1);
  return read;
}

}  // namespace

void Library::add(std::string_view signature, std::function<Outcome(const Call&)> run) {
  const std::size_t open = signature.find('('), close = signature.rfind(')');
  Builtin builtin{std::string(signature.substr(0, open)), {}, std::move(run), false};
  std::string_view list = signature.substr(open + 1, close - open - 1);
  while (!trimmed(list).empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string_view entry = trimmed(list.substr(0, comma));
    if (entry == "...")
      builtin.repeats = true;
    else
      builtin.parameters.push_back(read_parameter(entry));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  all_.push_back(std::move(builtin));
}

int Library::find(std::string_view name) const {
  const auto at = std::ranges::find(all_, name, &Builtin::name);
  return at == all_.end() ? -1 : static_cast<int>(at - all_.begin());
}

std::shared_ptr<const Program> compile(const Script& script, const Library& library, ScriptError& error) {
  ScriptErrors errors;
  auto program = compile(script, library, errors);
  if (program == nullptr) error = std::move(errors.front());
  return program;
}

std::shared_ptr<const Program> compile(const Script& script, const Library& library, ScriptErrors& errors,
                                       std::span<const std::string> given) {
  ScriptErrors own;
  try {
    auto program = Compiler(script, library, own).run(given);
    if (program != nullptr) return program;
  } catch (NotCompiled& refused) {
    own.push_back(std::move(refused.error));
  }
  std::ranges::move(own, std::back_inserter(errors));
  return nullptr;
}

std::shared_ptr<const Program> compile(std::string_view text, const Library& library, ScriptErrors& errors,
                                       std::span<const std::string> given) {
  Script script;
  if (parse(text, script, errors)) return compile(script, library, errors, given);
  // Of a text that is not understood only the functions that nobody knows are worth saying: its variables may be known.
  ScriptErrors unknown;
  (void)compile(script, library, unknown, given);
  for (ScriptError& one : unknown)
    if (one.is_call && errors.size() < kMostErrors) errors.push_back(std::move(one));
  return nullptr;
}

std::shared_ptr<const Program> compile(std::string_view text, const Library& library, ScriptError& error) {
  Script script;
  if (!parse(text, script, error)) return nullptr;
  return compile(script, library, error);
}

}  // namespace takt::languages::urscript
