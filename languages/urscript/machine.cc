#include "languages/urscript/machine.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace takt::languages::urscript {

namespace {

constexpr std::size_t kDeepestCalls = 200, kLargestStack = 2000, kMostThreads = 50;
constexpr std::ptrdiff_t kLongestList = 10'000;
constexpr int kDeepestList = 50;
constexpr std::size_t kLongestText = 65'536;
constexpr std::ptrdiff_t kElementsAnInstruction = 20, kCountedAfter = 100'000;

/// Takes what a value holds from `left`; lists of lists count whole. Stops below zero.
void weigh(const Value& value, std::ptrdiff_t& left, int depth) {
  const auto* list = value.get<List>();
  if (list == nullptr || left < 0) return;
  left = depth > 0 ? left - static_cast<std::ptrdiff_t>(list->size()) : -1;
  for (const Value& entry : *list) {
    if (left < 0) return;
    weigh(entry, left, depth - 1);
  }
}

constexpr std::ptrdiff_t kTextsElement = 32;  // characters that count as one element

/// Elements that a value holds; nothing if there are too many of them, or too deep ones.
std::optional<std::ptrdiff_t> elements_of(const Value& value) {
  if (const auto* text = value.get<std::string>()) {
    if (text->size() > kLongestText) return std::nullopt;
    return static_cast<std::ptrdiff_t>(text->size()) / kTextsElement;
  }
  std::ptrdiff_t left = kLongestList;
  weigh(value, left, kDeepestList);
  return left < 0 ? std::nullopt : std::optional(kLongestList - left);
}

/// @return the element, or null with the reason.
template <class Container>
Value element_at(const Container& container, std::int32_t index, std::string& problem) {
  if (index >= 0 && static_cast<std::size_t>(index) < container.size())
    return Value(container[static_cast<std::size_t>(index)]);
  problem = fmt::format("index {} out of bounds: the length is {}", index, container.size());
  return {};
}

Value element_of(const Value& of, const Value& index, std::string& problem) {
  const auto* number = index.get<std::int32_t>();
  if (number == nullptr) {
    problem = fmt::format("an index is an integer, and this is {}", index.kind());
    return {};
  }
  if (const auto* list = of.get<List>()) return element_at(*list, *number, problem);
  if (const auto* pose = of.get<Pose>()) return element_at(*pose, *number, problem);
  problem = fmt::format("{} has no elements", of.kind());
  return {};
}

/// @return what is wrong, or nothing.
std::string store_in(Value& to, std::span<const Value> indices, const Value& value) {
  std::string problem;
  const auto* index = indices.front().get<std::int32_t>();
  (void)element_of(to, indices.front(), problem);
  if (!problem.empty()) return problem;
  const auto at = static_cast<std::size_t>(*index);
  if (auto* list = to.get<List>()) {
    if (indices.size() > 1) return store_in((*list)[at], indices.subspan(1), value);
    (*list)[at] = value;
    return {};
  }
  const auto number = value.number();
  if (!number || indices.size() > 1)
    return fmt::format("an element of a pose is a number, and this is {}", value.kind());
  (*to.get<Pose>())[at] = *number;
  return {};
}

}  // namespace

Machine::Machine(std::shared_ptr<const Program> program, const Library& library, int first_thread)
    : program_(std::move(program)),
      library_(library),
      globals_(static_cast<std::size_t>(program_->globals)),
      next_id_(first_thread) {
  (void)start_thread(0, {});
}

bool Machine::enter(int line) {
  Thread& main = threads_.front();
  std::size_t& at = main.frames.back().at;
  for (const MainStatement& one : program_->statements) {
    if (one.line >= line) {
      at = one.begin;
      return true;
    }
    if (!one.assigns) continue;
    budget_ = kBudget;
    for (at = one.begin; at != one.end && !error_ && budget_ > 0; --budget_) {
      const Instruction& instruction = program_->code[at++];
      line_ = instruction.line;
      column_ = instruction.column;
      (void)step(main, instruction);
    }
  }
  return false;
}

int Machine::start_thread(int function, std::vector<Value> arguments) {
  Thread thread;
  thread.id = next_id_++;
  thread.locals = std::move(arguments);
  const CompiledFunction& code = program_->functions[static_cast<std::size_t>(function)];
  thread.locals.resize(static_cast<std::size_t>(code.locals));
  thread.frames.push_back({code.begin, 0, 0});
  threads_.push_back(std::move(thread));
  return threads_.back().id;
}

bool Machine::run_frame() {
  if (ended_) return false;
  // Threads that begin in this frame run in it as well.
  for (std::size_t i = 0; i < threads_.size() && !error_ && !stopping_; ++i) {
    if (threads_[i].ended) continue;
    run(threads_[i]);
    if (threads_.front().ended) break;
  }
  ended_ = error_ || stopping_ || threads_.front().ended;
  for (Thread& thread : threads_)
    if (thread.ended || ended_) ended_threads_.push_back(thread.id);
  if (ended_) {
    threads_.clear();
  } else {
    std::erase_if(threads_, [](const Thread& thread) { return thread.ended; });
  }
  return !ended_;
}

bool Machine::alive(int thread) const {
  return std::ranges::any_of(threads_, [=](const Thread& other) { return other.id == thread && !other.ended; });
}

std::vector<int> Machine::take_ended_threads() { return std::exchange(ended_threads_, {}); }

const Instruction* Machine::main_instruction() const {
  if (threads_.empty() || threads_.front().frames.empty()) return nullptr;
  const std::size_t at = threads_.front().frames.back().at;
  return &program_->code[at > 0 ? at - 1 : 0];
}

int Machine::line() const {
  const Instruction* const here = main_instruction();
  return here != nullptr ? here->line : line_;
}

int Machine::column() const {
  const Instruction* const here = main_instruction();
  return here != nullptr ? here->column : column_;
}

int Machine::frames_without_time() const {
  int most = 0;
  for (const Thread& thread : threads_) most = std::max(most, thread.overruns);
  return most;
}

bool Machine::resumes(Thread& thread) {
  if (thread.joins != 0) {
    const Thread* other = find(thread.joins);
    if (other != nullptr && !other->ended) return false;
    thread.joins = 0;
  }
  if (!thread.wait) return true;
  const Instruction& call = program_->code[thread.frames.back().at - 1];
  line_ = call.line;
  column_ = call.column;
  auto value = thread.wait();
  if (!value) return false;
  thread.wait = nullptr;
  push(thread, std::move(*value));
  return true;
}

void Machine::run(Thread& thread) {
  if (!resumes(thread)) return;
  for (budget_ = kBudget; budget_ > 0; --budget_) {
    if (thread.ended || error_ || stopping_) return;
    const Instruction& instruction = program_->code[thread.frames.back().at++];
    line_ = instruction.line;
    column_ = instruction.column;
    if (step(thread, instruction)) continue;
    thread.overruns = 0;
    return;
  }
  ++overruns_;
  ++thread.overruns;
}

bool Machine::step(Thread& thread, const Instruction& instruction) {
  switch (instruction.code) {
    case Code::kCall:
      enter(thread, instruction.a, instruction.b);
      return true;
    case Code::kBuiltin:
      return call_builtin(thread, instruction);
    case Code::kRun: {
      auto arguments = pop(thread, instruction.b);
      if (threads_.size() >= kMostThreads) return fail("too many threads"), false;
      const int id = start_thread(instruction.a, std::move(arguments));
      push(thread, ThreadHandle{id});
      return true;
    }
    case Code::kReturn:
      leave(thread);
      return !thread.ended;
    case Code::kKill:
      kill(pop(thread));
      return !thread.ended;
    case Code::kJoin: {
      const Value handle = pop(thread);
      thread.joins = handle.get<ThreadHandle>() != nullptr ? handle.get<ThreadHandle>()->id : 0;
      return resumes(thread);
    }
    case Code::kHalt:
      stopping_ = true;
      return false;
    default:
      return step_data(thread, instruction);
  }
}

bool Machine::step_data(Thread& thread, const Instruction& instruction) {
  const auto a = static_cast<std::size_t>(instruction.a);
  const std::size_t locals = thread.frames.back().locals;
  switch (instruction.code) {
    case Code::kConstant:
      push(thread, program_->constants[a]);
      break;
    case Code::kLoadLocal:
      push(thread, thread.locals[locals + a]);
      break;
    case Code::kLoadGlobal:
      push(thread, globals_[a]);
      break;
    case Code::kStoreLocal:
      thread.locals[locals + a] = pop(thread);
      break;
    case Code::kStoreGlobal:
      globals_[a] = pop(thread);
      break;
    case Code::kStoreLocalAt:
    case Code::kStoreGlobalAt:
      store_element(thread, instruction);
      break;
    case Code::kIndex:
      load_element(thread, instruction.a);
      break;
    case Code::kList:
      make_list(thread, instruction.a);
      break;
    case Code::kPose:
      make_pose(thread);
      break;
    case Code::kOperator:
      operate(thread, static_cast<Operator>(instruction.a));
      break;
    case Code::kNegate: {
      const Value value = pop(thread);
      auto result = negated(value);
      if (!result) fail(fmt::format("no minus of {}", value.kind()));
      push(thread, std::move(result).value_or(Value()));
      break;
    }
    case Code::kPop:
      (void)pop(thread);
      break;
    default:
      step_jump(thread, instruction);
  }
  return true;
}

void Machine::step_jump(Thread& thread, const Instruction& instruction) {
  std::size_t& at = thread.frames.back().at;
  const auto to = static_cast<std::size_t>(instruction.a);
  if (instruction.code == Code::kJump || instruction.code == Code::kJumpBack) {
    at = to;
    return;
  }
  const auto truth = thread.stack.back().truth();
  if (!truth) return fail(fmt::format("a condition is a Boolean, and this is {}", thread.stack.back().kind()));
  switch (instruction.code) {
    case Code::kNot:
      thread.stack.back() = !*truth;
      return;
    case Code::kJumpIfFalse:
      (void)pop(thread);
      if (!*truth) at = to;
      return;
    case Code::kShortAnd:
    case Code::kShortOr:
      if (*truth == (instruction.code == Code::kShortOr)) {
        thread.stack.back() = *truth;
        at = to;
      } else {
        (void)pop(thread);
      }
      return;
    default:
      return;
  }
}

void Machine::enter(Thread& thread, int function, int arguments) {
  const CompiledFunction& code = program_->functions[static_cast<std::size_t>(function)];
  auto values = pop(thread, arguments);
  if (thread.frames.size() >= kDeepestCalls) return fail("calls are nested too deeply");
  const std::size_t locals = thread.locals.size();
  thread.locals.insert(thread.locals.end(), std::make_move_iterator(values.begin()),
                       std::make_move_iterator(values.end()));
  thread.locals.resize(locals + static_cast<std::size_t>(code.locals));
  thread.frames.push_back({code.begin, locals, thread.stack.size()});
}

void Machine::leave(Thread& thread) {
  Value value = pop(thread);
  const Frame frame = thread.frames.back();
  thread.frames.pop_back();
  thread.locals.resize(frame.locals);
  thread.stack.resize(frame.stack);
  thread.ended = thread.frames.empty();
  if (!thread.ended) push(thread, std::move(value));
}

bool Machine::call_builtin(Thread& thread, const Instruction& instruction) {
  const Builtin& builtin = library_.all()[static_cast<std::size_t>(instruction.a)];
  const auto arguments = pop(thread, instruction.b);
  Outcome outcome = builtin.run({arguments, thread.id});
  if (auto* value = std::get_if<Value>(&outcome)) {
    push(thread, std::move(*value));
    return !stopping_;
  }
  if (auto* wait = std::get_if<Wait>(&outcome)) {
    thread.wait = std::move(*wait);
    return false;
  }
  fail(builtin.name + ": " + std::get<Failed>(outcome).text);
  return false;
}

void Machine::load_element(Thread& thread, int indices) {
  const auto list = pop(thread, indices);
  Value value = pop(thread);
  std::string problem;
  for (const Value& index : list) {
    value = element_of(value, index, problem);
    if (!problem.empty()) break;
  }
  if (!problem.empty()) fail(problem);
  push(thread, std::move(value));
}

void Machine::store_element(Thread& thread, const Instruction& instruction) {
  const Value value = pop(thread);
  const auto indices = pop(thread, instruction.b);
  const auto a = static_cast<std::size_t>(instruction.a);
  const bool local = instruction.code == Code::kStoreLocalAt;
  Value& to = local ? thread.locals[thread.frames.back().locals + a] : globals_[a];
  if (std::string problem = store_in(to, indices, value); !problem.empty()) fail(std::move(problem));
}

void Machine::make_list(Thread& thread, int count) { push(thread, pop(thread, count)); }

void Machine::make_pose(Thread& thread) {
  const auto parts = pop(thread, 6);
  Pose pose{};
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const auto number = parts[i].number();
    if (!number) return fail(fmt::format("a pose is made of numbers, and this is {}", parts[i].kind()));
    pose[i] = *number;
  }
  push(thread, pose);
}

void Machine::operate(Thread& thread, Operator op) {
  const Value b = pop(thread), a = pop(thread);
  auto result = apply(op, a, b);
  if (!result) fail(fmt::format("no '{}' of {} and {}", name_of(op), a.kind(), b.kind()));
  push(thread, std::move(result).value_or(Value()));
}

void Machine::kill(const Value& handle) {
  const auto* thread = handle.get<ThreadHandle>();
  if (thread == nullptr) return;
  if (Thread* found = find(thread->id)) found->ended = true;
}

Machine::Thread* Machine::find(int id) {
  const auto at = std::ranges::find(threads_, id, &Thread::id);
  return at == threads_.end() ? nullptr : &*at;
}

void Machine::push(Thread& thread, Value value) {
  const auto elements = elements_of(value);
  if (thread.stack.size() >= kLargestStack || !elements) fail("a value or an expression is too large");
  if (elements.value_or(0) > 0) charge(*elements);
  thread.stack.push_back(std::move(value));
}

/// Copies take time as instructions do. All that is held is counted again when much of it is new.
void Machine::charge(std::ptrdiff_t elements) {
  budget_ -= static_cast<int>(elements / kElementsAnInstruction);
  made_ += elements;
  if (made_ < kCountedAfter) return;
  made_ = 0;
  if (held_elements() > kMostElements) fail("the lists and texts of the program are too large");
}

std::ptrdiff_t Machine::held_elements() const {
  std::ptrdiff_t sum = 0;
  const auto add = [&](const std::vector<Value>& values) {
    for (const Value& value : values) sum += elements_of(value).value_or(kLongestList);
  };
  add(globals_);
  for (const Thread& thread : threads_) {
    add(thread.locals);
    add(thread.stack);
  }
  return sum;
}

Value Machine::pop(Thread& thread) {
  Value value = std::move(thread.stack.back());
  thread.stack.pop_back();
  return value;
}

std::vector<Value> Machine::pop(Thread& thread, int count) {
  const auto from = thread.stack.end() - count;
  std::vector<Value> values(std::make_move_iterator(from), std::make_move_iterator(thread.stack.end()));
  thread.stack.erase(from, thread.stack.end());
  return values;
}

void Machine::fail(std::string text) {
  if (!error_) error_ = ScriptError{line_, column_, std::move(text)};
}

}  // namespace takt::languages::urscript
