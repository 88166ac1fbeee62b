// Statements, calls, interrupts.
#include "languages/krl/machine.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "languages/krl/builtins.h"

namespace takt::languages::krl {

using Kind = Statement::Kind;
using OpCode = Instruction::Code;

Machine::Machine(const Program& program, Host& host) : program_(program), host_(host) {
  elements_ = kMostElements;
  for (std::size_t m = 0; m < program.modules.size(); ++m) {
    modules_.emplace_back();
    for (const Variable& one : program.variables[m])
      modules_.back().push_back(make_value(one.type, one.size, elements_));
  }
  if (elements_ < 0) fail({}, Code::kTooLarge, "the variables have too many elements", "Make arrays smaller");
  // The prelude comes first: others build on its values.
  for (std::size_t i = 0; i < program.modules.size() && !failed(); ++i) {
    const std::size_t m = program.modules.size() - 1 - i;
    module_ = static_cast<int>(m);
    for (std::size_t v = 0; v < program.variables[m].size() && !failed(); ++v) {
      const Variable& variable = program.variables[m][v];
      for (const auto& [index, expression] : program.modules[m].data[v].initial) {
        Value* target = &modules_[m][v];
        if (!index.empty() && target->kind == Value::Kind::kArray) {
          std::size_t at = 0;
          bool known = index.size() == target->size.size();
          for (std::size_t k = 0; k < index.size() && known; ++k) {
            known = index[k] >= 1 && index[k] <= target->size[k];
            at = at * static_cast<std::size_t>(target->size[k]) + static_cast<std::size_t>(index[k]) - 1;
          }
          if (!known)
            fail(expression->at, Code::kOutOfRange, "there is no such element", "Use an index that the array has");
          target = known ? &target->parts[at] : target;
        }
        const Value value = evaluate(*expression, variable.type.structure);
        if (failed()) break;
        const std::string wrong = assign(*target, variable.type, value);
        if (!wrong.empty()) fail(expression->at, Code::kWrongType, wrong, "Give a value of its type");
      }
    }
  }
  if (failed()) diagnostics_.list().back().file = program.modules[static_cast<std::size_t>(module_)].data_file;
  const auto numbers = [&](std::string_view name, Value value) {
    for (Value& one : shared(name).parts) one = value;
  };
  numbers("$VEL_AXIS", Value::of(std::int64_t{100}));
  numbers("$ACC_AXIS", Value::of(std::int64_t{100}));
  numbers("$FLAG", Value::of(false));
  for (const char* name : {"BASE_DATA", "TOOL_DATA"})
    for (Value& one : shared(name).parts) set_pose(one, Eigen::Isometry3d::Identity());
  if (!failed()) (void)call(program.main, nullptr, -1);
}

void Machine::set_frame(std::string_view name, int number, const Eigen::Isometry3d& X) {
  Value& whole = shared(name);
  if (number == 0) return set_pose(whole, X);
  if (number >= 1 && number <= static_cast<int>(whole.parts.size()))
    set_pose(whole.parts[static_cast<std::size_t>(number) - 1], X);
}

void Machine::set_axes(std::string_view name, const std::vector<double>& axes) {
  Value& whole = shared(name);
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (const int at = whole.structure->find(host_.axis_names()[i]); at >= 0)
      whole.parts[static_cast<std::size_t>(at)] = Value::of(axes[i]);
}

bool Machine::enter(int line) {
  if (frames_.size() != 1) return false;
  const CompiledFunction& main = program_.functions[static_cast<std::size_t>(program_.main)];
  for (std::size_t at = main.begin; at < program_.code.size(); ++at) {
    const Instruction& one = program_.code[at];
    if (one.code == OpCode::kReturn && one.statement == nullptr) return false;
    if (one.statement == nullptr || one.statement->at.line < line) continue;
    frames_.back().at = at;
    return true;
  }
  return false;
}

TextLocation Machine::at() const {
  if (frames_.empty()) return {};
  const Instruction& one = program_.code[frames_.back().at];
  return one.statement != nullptr ? one.statement->at : one.a != nullptr ? one.a->at : TextLocation{};
}

bool Machine::in_interrupt() const {
  return std::ranges::any_of(frames_, [](const Frame& one) { return one.interrupt >= 0; });
}

Machine::Progress Machine::advance() {
  if (failed()) return Progress::kFailed;
  copies_ = 0;
  poll_interrupts();
  asked_ = false;
  for (int spent = 0; !failed(); ++spent) {
    if (halted_) return Progress::kHalted;
    if (frames_.empty()) return host_.settled() ? Progress::kEnded : Progress::kRunning;
    Frame& frame = frames_.back();
    module_ = program_.functions[static_cast<std::size_t>(frame.function)].module;
    const Instruction& one = program_.code[frame.at];
    if (spent >= kMostStatements || copies_ > kMostCopies) {
      fail(at(), Code::kTooLarge,
           spent >= kMostStatements
               ? fmt::format("{} statements without a motion or a wait", kMostStatements)
               : fmt::format("{} elements of arrays copied without a motion or a wait", kMostCopies),
           "Put a WAIT or a motion into the loop");
      break;
    }
    if (blocked(one)) return failed() ? Progress::kFailed : Progress::kRunning;
    const Step next = step(one);
    if (next != Step::kNext) return failed() ? Progress::kFailed : Progress::kRunning;
  }
  return Progress::kFailed;
}

bool Machine::blocked(const Instruction& one) {
  if (resuming_) {
    if (!host_.settled()) return true;
    resuming_ = false;
    last_axes_.reset();
    last_flange_.reset();
  }
  if (in_interrupt()) return braked_ && !host_.settled();
  const double advance = shared("$ADVANCE").number();
  if (advance <= 0 && !host_.settled()) return true;
  const bool is_end =
      one.code == OpCode::kReturn && (frames_.size() == 1 || std::ranges::any_of(interrupts_, [&](const auto& each) {
                                        return each.second.level + 1 == frames_.size();
                                      }));
  if (is_end && !host_.settled()) return true;
  if (one.stops && !continues_ && !host_.settled()) return true;
  if (one.code != OpCode::kExecute) return false;
  const Kind kind = one.statement->kind;
  if (kind != Kind::kMotion && kind != Kind::kSpline) return false;
  return host_.unfinished() > static_cast<int>(std::min(advance, 5.0)) ||
         (!host_.settled() && ((!last_axes_ && !last_flange_) || needs_place(*one.statement)));
}

Machine::Step Machine::step(const Instruction& one) {
  Frame& frame = frames_.back();
  const auto jump = [&](int target) { frame.at = static_cast<std::size_t>(target); };
  switch (one.code) {
    case OpCode::kExecute: {
      const bool is_for = one.statement->kind == Kind::kFor;
      if (is_for) assign_place(*one.statement->a, evaluate(*one.statement->b));
      const std::size_t depth = frames_.size();
      const Step next = is_for ? Step::kNext : execute(*one.statement);
      if (one.statement->kind != Kind::kContinue && next != Step::kStay) continues_ = false;
      if (next != Step::kStay && frames_.size() == depth && one.statement->kind != Kind::kResume) ++frames_.back().at;
      return next;
    }
    case OpCode::kSet: {
      Value value = one.a != nullptr ? evaluate(*one.a) : Value::of(std::int64_t{1});
      if (failed()) return Step::kStay;
      const Type type =
          program_.functions[static_cast<std::size_t>(frame.function)].locals[static_cast<std::size_t>(one.x)].type;
      if (one.a != nullptr && one.a->kind == Expression::Kind::kAggregate) value = evaluate(*one.a, type.structure);
      const std::string wrong = assign(frame.locals[static_cast<std::size_t>(one.x)], type, value);
      if (!wrong.empty()) fail(one.a != nullptr ? one.a->at : at(), Code::kWrongType, wrong, "Check the value");
      ++frame.at;
      return Step::kNext;
    }
    case OpCode::kCall:
      ++frame.at;
      if (!call(one.x, one.a, one.y)) return Step::kStay;
      return Step::kNext;
    case OpCode::kJump:
      jump(one.x);
      return Step::kNext;
    case OpCode::kJumpBack:
      jump(one.x);
      return std::exchange(asked_, false) ? Step::kYield : Step::kNext;
    case OpCode::kJumpIfFalse:
      if (truth(*one.a)) {
        ++frame.at;
      } else {
        jump(one.x);
      }
      return Step::kNext;
    case OpCode::kForTest:
      if (for_test(one)) {
        ++frame.at;
      } else {
        jump(one.x);
      }
      return Step::kNext;
    case OpCode::kForStep: {
      const Value step = frame.locals[static_cast<std::size_t>(one.y) + 1];
      Value sum;
      const std::string wrong = operate(Operator::kAdd, evaluate(*one.a), step, sum);
      if (!wrong.empty()) fail(one.a->at, Code::kInvalidValue, wrong, "Use numbers");
      if (!failed()) assign_place(*one.a, sum);
      ++frame.at;
      return Step::kNext;
    }
    case OpCode::kCase:
      if (const Value label = evaluate(*one.a); equal(label, frame.locals[static_cast<std::size_t>(one.y)])) {
        jump(one.x);
      } else {
        ++frame.at;
      }
      return Step::kNext;
    case OpCode::kReturn:
      leave(one.a);
      return Step::kNext;
  }
  return Step::kNext;
}

bool Machine::for_test(const Instruction& one) {
  const Frame& frame = frames_.back();
  const double value = number(*one.a);
  const Value& limit = frame.locals[static_cast<std::size_t>(one.y)];
  const Value& step = frame.locals[static_cast<std::size_t>(one.y) + 1];
  if (failed()) return false;
  if (!limit.is_number() || !step.is_number() || step.number() == 0.0) {
    fail(one.a->at, Code::kInvalidValue, "FOR needs numbers, and a step that is not 0", "Check its values");
    return false;
  }
  return step.number() > 0 ? value <= limit.number() : value >= limit.number();
}

bool Machine::call(int function, const Expression* call, int result) {
  const CompiledFunction& target = program_.functions[static_cast<std::size_t>(function)];
  if (frames_.size() >= kMostDepth) {
    fail(call != nullptr ? call->at : TextLocation{}, Code::kTooLarge,
         fmt::format("calls are nested more than {} deep", kMostDepth), "End the recursion before");
    return false;
  }
  Frame made;
  made.function = function;
  made.at = target.begin;
  made.call = call;
  made.result = result;
  const std::int64_t before = elements_;
  for (const Variable& one : target.locals) made.locals.push_back(make_value(one.type, one.size, elements_));
  made.elements = before - elements_;
  copies_ += made.elements;
  if (elements_ < 0) {
    fail(call != nullptr ? call->at : TextLocation{}, Code::kTooLarge, "the variables have too many elements",
         "Make arrays smaller, or end the recursion before");
    return false;
  }
  for (std::size_t i = 0; call != nullptr && i < call->parts.size(); ++i) {
    if (!call->parts[i]) continue;
    const Value value = evaluate(*call->parts[i], target.locals[i].type.structure);
    if (failed()) return false;
    if (value.nothing() && target.source->parameters[i].is_out) continue;
    const bool whole_array = value.kind == Value::Kind::kArray && made.locals[i].kind != Value::Kind::kStructure;
    const std::string wrong =
        whole_array ? (made.locals[i] = value, std::string()) : assign(made.locals[i], target.locals[i].type, value);
    if (!wrong.empty()) {
      fail(call->parts[i]->at, Code::kWrongType, wrong, "Give a value of the parameter's type");
      return false;
    }
  }
  frames_.push_back(std::move(made));
  return true;
}

void Machine::leave(const Expression* value) {
  Value result;
  const CompiledFunction& left = program_.functions[static_cast<std::size_t>(frames_.back().function)];
  if (value != nullptr) {
    const std::string wrong = assign(result, left.result, evaluate(*value, left.result.structure));
    if (!failed() && !wrong.empty()) fail(value->at, Code::kWrongType, wrong, "Return a value of its type");
  }
  if (failed()) return;
  Frame over = std::move(frames_.back());
  frames_.pop_back();
  elements_ += over.elements;
  std::erase_if(interrupts_, [&](const auto& each) { return each.second.level >= frames_.size(); });
  if (over.interrupt >= 0) {
    if (std::exchange(braked_, false)) host_.go_on();
    return;
  }
  if (frames_.empty()) return;
  module_ = program_.functions[static_cast<std::size_t>(frames_.back().function)].module;
  for (std::size_t i = 0; over.call != nullptr && i < over.call->parts.size(); ++i) {
    const ExpressionPtr& argument = over.call->parts[i];
    if (!argument || !left.source->parameters[i].is_out || over.locals[i].nothing()) continue;
    if (argument->kind == Expression::Kind::kLiteral) continue;
    if (over.locals[i].kind == Value::Kind::kArray) {
      if (Value* const target = place(*argument, nullptr)) *target = std::move(over.locals[i]);
    } else {
      assign_place(*argument, over.locals[i]);
    }
  }
  if (over.result < 0) return;
  if (result.nothing())
    fail(over.call->at, Code::kMissing, fmt::format("'{}' ended without RETURN", left.source->name), "Return a value");
  frames_.back().locals[static_cast<std::size_t>(over.result)] = std::move(result);
}

void Machine::assign_place(const Expression& target, const Value& value) {
  if (failed()) return;
  Type type;
  Value* const found = place(target, &type);
  if (found == nullptr) return;
  if (found->kind == Value::Kind::kArray && value.kind == Value::Kind::kArray && found->size == value.size) {
    *found = value;
    return;
  }
  const std::string wrong = assign(*found, type, value);
  if (!wrong.empty()) fail(target.at, Code::kWrongType, wrong, "Assign a value of its type");
}

Machine::Step Machine::execute(const Statement& one) {
  switch (one.kind) {
    case Kind::kAssign: {
      const Expression* root = one.a.get();
      while (root->kind == Expression::Kind::kField || root->kind == Expression::Kind::kIndex)
        root = root->parts[0].get();
      if (root->where == Expression::Where::kLive) return assign_live(*one.a, *one.b, static_cast<Live>(root->live));
      Type type;
      if (place(*one.a, &type) == nullptr) return Step::kStay;
      assign_place(*one.a, evaluate(*one.b, type.structure));
      return Step::kNext;
    }
    case Kind::kCall:
      host_.call(one.a->name, module_, one.at);
      last_axes_.reset();  // it may move the arm
      last_flange_.reset();
      return Step::kNext;
    case Kind::kMotion:
    case Kind::kSpline:
      return move(one);
    case Kind::kWaitSeconds:
    case Kind::kWaitFor:
      return wait(one);
    case Kind::kTrigger:
      pend_trigger(one);
      return Step::kNext;
    case Kind::kInterruptDeclare:
      declare_interrupt(one);
      return Step::kNext;
    case Kind::kInterruptSwitch:
      return switch_interrupts(one);
    case Kind::kBrake:
      if (!in_interrupt()) {
        fail(one.at, Code::kNotPossibleNow, "BRAKE outside of an interrupt program", "Use WAIT, or remove it");
        return Step::kStay;
      }
      if (!std::exchange(braked_, true)) host_.brake();
      return Step::kNext;
    case Kind::kResume:
      return resume(one);
    case Kind::kHalt:
      halted_ = true;
      return Step::kStay;
    case Kind::kContinue:
      continues_ = true;
      return Step::kNext;
    case Kind::kPulse: {
      const Expression& signal = *one.a;
      const bool is_output = signal.kind == Expression::Kind::kIndex && signal.parts.size() == 2 &&
                             signal.parts[0]->where == Expression::Where::kLive &&
                             signal.parts[0]->live == static_cast<int>(Live::kOut);
      if (!is_output) {
        fail(one.at, Code::kWrongType, "PULSE of what is no output", "Write PULSE($OUT[n], TRUE, seconds)");
        return Step::kStay;
      }
      const int index = static_cast<int>(std::clamp(number(*signal.parts[1]), -1.0, 1e6));
      const bool level = truth(*one.b);
      const double seconds = number(*one.c);
      if (failed()) return Step::kStay;
      const std::string wrong =
          host_.write(Live::kOut, index, level ? 1.0 : 0.0, std::clamp(seconds, 0.001, 3600.0), true);
      if (!wrong.empty()) fail(one.at, Code::kUnknownName, wrong, "Name it in the map of the program");
      return Step::kNext;
    }
    default:
      return Step::kNext;
  }
}

Machine::Step Machine::assign_live(const Expression& target, const Expression& value, Live live) {
  if (target.kind != Expression::Kind::kIndex || target.parts.size() != 2) {
    fail(target.at, Code::kWrongType, "a signal without a number", "Give its number in [ ]");
    return Step::kStay;
  }
  const double index = std::clamp(number(*target.parts[1]), -1.0, 1e6);
  if (failed()) return Step::kStay;
  if (live == Live::kCyclicFlag) {
    if (cyclic_.size() < 1024) cyclic_[std::llround(index)] = &value;
    return Step::kNext;
  }
  if (live == Live::kTimer || live == Live::kTimerStop) {
    Timer& timer = timers_[std::clamp<std::int64_t>(std::llround(index), 0, 1000)];
    const double now = host_.now();
    if (timer.runs) timer.value += (now - timer.since) * 1000.0;
    timer.since = now;
    if (live == Live::kTimer) timer.value = number(value);
    if (live == Live::kTimerStop) timer.runs = !truth(value);
    return Step::kNext;
  }
  const double amount = live == Live::kOut ? (truth(value) ? 1.0 : 0.0) : number(value);
  if (failed()) return Step::kStay;
  const std::string wrong =
      host_.write(live, static_cast<int>(index), amount, std::nullopt, continues_ || in_interrupt());
  if (!wrong.empty()) fail(target.at, Code::kUnknownName, wrong, "Name it in the map of the program");
  return Step::kNext;
}

Machine::Step Machine::wait(const Statement& one) {
  Frame& frame = frames_.back();
  if (one.kind == Kind::kWaitFor) {
    const bool holds = truth(*one.a);
    if (failed()) return Step::kStay;
    return holds || host_.skips_wait(std::nullopt) ? Step::kNext : Step::kStay;
  }
  if (!frame.deadline) {
    const double seconds = number(*one.a);
    if (failed()) return Step::kStay;
    frame.deadline = host_.now() + std::clamp(seconds, 0.0, 1e6);
  }
  const double left = *frame.deadline - host_.now();
  if (left > 1e-9 && !host_.skips_wait(left)) return Step::kStay;
  frame.deadline.reset();
  return Step::kNext;
}

// -- Interrupts ------------------------------------------------------------------------------------------------------

void Machine::declare_interrupt(const Statement& one) {
  const double number = this->number(*one.a);
  constexpr double kMost = 128;
  if (!failed() && !(number >= 1 && number <= kMost))
    fail(one.at, Code::kOutOfRange, fmt::format("interrupt {}", number), "Use a number from 1 to 128");
  if (failed()) return;
  Interrupt& made = interrupts_[static_cast<int>(number)];
  made = {};
  made.declared = &one;
  made.module = module_;
  made.level = one.flag ? 0 : frames_.size() - 1;
}

Machine::Step Machine::switch_interrupts(const Statement& one) {
  const double number = one.a ? this->number(*one.a) : 0.0;
  if (failed()) return Step::kStay;
  const auto found = interrupts_.find(static_cast<int>(number));
  if (one.a && found == interrupts_.end()) {
    fail(one.at, Code::kUnknownName, fmt::format("interrupt {} was not declared", number),
         "Declare it before with INTERRUPT DECL");
    return Step::kStay;
  }
  for (auto& [key, interrupt] : interrupts_) {
    if (one.a && key != found->first) continue;
    if (one.word == "ON" || one.word == "OFF") {
      interrupt.on = one.word == "ON";
      interrupt.pending = false;
      std::vector<Frame> above = take_above(interrupt.level);
      interrupt.before = truth(*interrupt.declared->b);  // an edge counts from now on
      for (Frame& each : above) frames_.push_back(std::move(each));
    } else {
      interrupt.enabled = one.word == "ENABLE";
    }
  }
  return Step::kNext;
}

void Machine::poll_interrupts() {
  if (resuming_ || frames_.empty()) return;
  int active = 1000;
  for (const Frame& one : frames_)
    if (one.interrupt >= 0) active = std::min(active, one.interrupt);
  for (auto& [number, interrupt] : interrupts_) {
    if (!interrupt.on || interrupt.level >= frames_.size()) continue;
    // The condition is that of the program that declared it.
    module_ = interrupt.module;
    std::vector<Frame> above = take_above(interrupt.level);
    const bool holds = truth(*interrupt.declared->b);
    for (Frame& one : above) frames_.push_back(std::move(one));
    if (failed()) return;
    if (holds && !std::exchange(interrupt.before, holds)) interrupt.pending = true;
    interrupt.before = holds;
  }
  for (auto& [number, interrupt] : interrupts_) {
    if (!interrupt.on || !interrupt.enabled || !interrupt.pending || number >= active) continue;
    interrupt.pending = false;
    return begin_interrupt(number);
  }
}

std::vector<Machine::Frame> Machine::take_above(std::size_t level) {
  std::vector<Frame> above(std::make_move_iterator(frames_.begin() + static_cast<std::ptrdiff_t>(level) + 1),
                           std::make_move_iterator(frames_.end()));
  frames_.resize(level + 1);
  return above;
}

/// Its arguments are those of the program that declared it.
void Machine::begin_interrupt(int number) {
  const Interrupt& interrupt = interrupts_[number];
  const Expression& call = *interrupt.declared->c;
  module_ = interrupt.module;
  std::vector<Frame> above = take_above(interrupt.level);
  const bool begun = above.size() + frames_.size() < kMostDepth && this->call(call.slot, &call, -1);
  std::optional<Frame> routine;
  if (begun) {
    routine = std::move(frames_.back());
    frames_.pop_back();
  }
  for (Frame& one : above) frames_.push_back(std::move(one));
  if (!routine) {
    fail(call.at, Code::kTooLarge, fmt::format("calls are nested more than {} deep", kMostDepth),
         "End the recursion before");
    return;
  }
  routine->interrupt = number;
  routine->call = nullptr;
  frames_.push_back(std::move(*routine));
}

Machine::Step Machine::resume(const Statement& one) {
  const auto found = std::ranges::find_if(frames_, [](const Frame& each) { return each.interrupt >= 0; });
  if (found == frames_.end()) {
    fail(one.at, Code::kNotPossibleNow, "RESUME outside of an interrupt program", "Remove it");
    return Step::kStay;
  }
  const auto interrupted = static_cast<std::size_t>(found - frames_.begin()) - 1;
  const std::size_t level = interrupts_[found->interrupt].level;
  if (interrupted <= level) {
    fail(one.at, Code::kNotPossibleNow, "RESUME while no program is called that it could end",
         "Move what may be ended into a program of its own, which is called after INTERRUPT ON");
    return Step::kStay;
  }
  while (frames_.size() > level + 1) {
    elements_ += frames_.back().elements;
    frames_.pop_back();
  }
  std::erase_if(interrupts_, [&](const auto& each) { return each.second.level > level; });
  braked_ = false;
  resuming_ = true;
  triggers_.clear();
  host_.forget();
  return Step::kNext;
}

}  // namespace takt::languages::krl
