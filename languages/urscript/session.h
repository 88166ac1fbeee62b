#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "languages/urscript/arm_functions.h"

namespace takt::languages::urscript {

/// A variable that a program has from the map.
struct GivenVariable {
  std::string name;
  Value value;
};

/// A text with the name of its file.
struct ScriptText {
  std::string file, source;
};

/// Compiles a program for an arm. `calls` are functions without parameters that the map carries out; `given` are names
/// of variables that it has before the first statement. Diagnostics: all faults, with line and column. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const Program>> compile_for_arm(const ScriptText& text,
                                                                     const std::set<std::string>& calls,
                                                                     const std::vector<std::string>& given);

/// A program on an arm: advance() at least once in each cycle. The same program on hosts that answer the same does the
/// same. Thread: one.
class Session {
 public:
  enum class Progress : std::uint8_t { kRunning, kEnded, kFailed };
  /// A thread may compute so many frames without taking time.
  static constexpr int kMostFrames = 10;

  /// @param calls, given  as it was compiled with; the host outlives it
  Session(std::shared_ptr<const Program> program, Host& host, const std::set<std::string>& calls,
          const std::vector<GivenVariable>& given);

  /// Begins at the first statement of the main program from this line on. @return false: there is none
  [[nodiscard]] bool enter(int line) { return machine_.enter(line); }
  /// Runs until all threads wait. When the program ends, what lasts ends; motions that were given go on.
  Progress advance();
  /// It has ended by `halt`.
  [[nodiscard]] bool halted() const { return halted_; }
  /// Why it failed.
  [[nodiscard]] const ScriptError& error() const { return error_; }
  /// Where the main thread is.
  [[nodiscard]] TextLocation at() const { return {machine_.line(), machine_.column()}; }
  /// When the first thread that waits for a time goes on, s; infinite: none does.
  [[nodiscard]] double next_time() const { return functions_.next_time(); }

 private:
  Progress end(Progress progress);

  Host& host_;
  ArmFunctions functions_;
  Library library_;
  Machine machine_;
  ScriptError error_;
  Progress progress_ = Progress::kRunning;
  bool halted_ = false;
};

}  // namespace takt::languages::urscript
