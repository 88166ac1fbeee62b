#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "languages/urscript/program.h"

namespace takt::languages::urscript {

/// Runs one program in the frames of a controller. Each thread runs until it takes time (a built-in function that
/// waits) or blocks, and goes on in a later frame; only there do threads alternate. A thread that loops without taking
/// time gives up the frame after kBudget instructions. What a program may use is bounded: depth of calls, threads,
/// lengths of lists and strings, elements of all its variables. One thread of the process.
class Machine {
 public:
  static constexpr int kBudget = 50'000;                    ///< instructions of one thread in one frame
  static constexpr std::ptrdiff_t kMostElements = 500'000;  ///< of all lists that a program holds

  /// @param library  outlives the machine, and is the one that the program was compiled with
  /// @param first_thread  number of the main thread; the others count on from it
  Machine(std::shared_ptr<const Program> program, const Library& library, int first_thread = 1);

  /// Goes to the first statement of the main program from this line on, before the first frame. Assignments before it
  /// that need nothing but variables are carried out. @return false: there is no such statement
  [[nodiscard]] bool enter(int line);
  /// One frame of all threads, in the order in which they began. @return false if the program has ended.
  bool run_frame();
  [[nodiscard]] bool ended() const { return ended_; }
  /// Why it ended, if it did not come to its end.
  [[nodiscard]] const std::optional<ScriptError>& error() const { return error_; }
  [[nodiscard]] const Program& program() const { return *program_; }
  /// Ends the program with what is running now. Built-in functions may call it.
  void stop() { stopping_ = true; }
  /// It ended by stop(), or by `halt`.
  [[nodiscard]] bool stopped() const { return stopping_; }
  /// Ends the program with an error where it is. Built-in functions may call it while they wait.
  void fail(std::string text);
  /// Sets a variable that the program was compiled with, by its number. Before the first frame.
  void set_global(std::size_t number, Value value) { globals_[number] = std::move(value); }
  [[nodiscard]] bool alive(int thread) const;
  /// Threads that have ended since the last call.
  [[nodiscard]] std::vector<int> take_ended_threads();
  /// The line that the main thread is at.
  [[nodiscard]] int line() const;
  [[nodiscard]] int column() const;
  /// Where the thread is that runs now, or asks whether it may go on.
  [[nodiscard]] int current_line() const { return line_; }
  [[nodiscard]] int current_column() const { return column_; }
  /// Frames in which some thread used up its budget.
  [[nodiscard]] std::uint64_t overruns() const { return overruns_; }
  /// In how many frames one after the other a thread has used up its budget: the most of all threads.
  [[nodiscard]] int frames_without_time() const;

 private:
  struct Frame {
    std::size_t at = 0;  // next instruction
    std::size_t locals = 0, stack = 0;
  };
  struct Thread {
    int id = 0;
    std::vector<Frame> frames;
    std::vector<Value> locals, stack;
    Wait wait;
    int joins = 0;  // id of a thread
    bool ended = false;
    int overruns = 0;  // one after the other
  };
  using Code = Instruction::Code;

  int start_thread(int function, std::vector<Value> arguments);
  void run(Thread& thread);
  /// @return true if the thread waits now.
  bool resumes(Thread& thread);
  /// @return false if the thread gives up the frame.
  bool step(Thread& thread, const Instruction& instruction);
  bool step_data(Thread& thread, const Instruction& instruction);
  void step_jump(Thread& thread, const Instruction& instruction);
  void enter(Thread& thread, int function, int arguments);
  void leave(Thread& thread);
  bool call_builtin(Thread& thread, const Instruction& instruction);
  void load_element(Thread& thread, int indices);
  void store_element(Thread& thread, const Instruction& instruction);
  void make_list(Thread& thread, int count);
  void make_pose(Thread& thread);
  void operate(Thread& thread, Operator op);
  void kill(const Value& handle);
  [[nodiscard]] Thread* find(int id);
  void push(Thread& thread, Value value);
  Value pop(Thread& thread);
  [[nodiscard]] std::vector<Value> pop(Thread& thread, int count);
  [[nodiscard]] const Instruction* main_instruction() const;
  void charge(std::ptrdiff_t elements);
  [[nodiscard]] std::ptrdiff_t held_elements() const;

  std::shared_ptr<const Program> program_;
  const Library& library_;
  std::deque<Thread> threads_;
  std::vector<Value> globals_;
  std::vector<int> ended_threads_;
  std::optional<ScriptError> error_;
  int next_id_, line_ = 1, column_ = 1;
  int budget_ = 0;           // of the thread that runs
  std::ptrdiff_t made_ = 0;  // elements since they were counted
  bool ended_ = false, stopping_ = false;
  std::uint64_t overruns_ = 0;
};

}  // namespace takt::languages::urscript
