#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "languages/urscript/arguments.h"
#include "languages/urscript/host.h"
#include "languages/urscript/machine.h"

namespace takt::languages::urscript {

/// What the built-in functions of an arm have in common: whose motions it makes, its tool, and when a call waits
/// (docs/urscript.md). Thread: one.
class ArmFunctions {
 public:
  static constexpr int kAdvance = 3;  ///< motions behind the one that is carried out which may be given (rule U2)

  explicit ArmFunctions(Host& host) : host_(host), X_FT_(host.tool()) {}

  /// The machine whose program calls them.
  void attach(Machine& machine) { machine_ = &machine; }
  /// These threads have ended; the motions of one that commanded the arm end with it.
  void release(const std::vector<int>& threads);
  /// The thread that commands the arm; 0: none has.
  [[nodiscard]] int owner() const { return owner_; }
  /// Something moves, or lasts.
  [[nodiscard]] bool busy() const { return !host_.settled() || host_.lasts(); }
  /// When the first call that waits for a time goes on, s; infinite: none does. Since begin_round().
  [[nodiscard]] double next_time() const { return next_time_; }
  void begin_round() { next_time_ = std::numeric_limits<double>::infinity(); }

 private:
  friend class ArmLibrary;
  using Act = std::function<std::optional<Value>()>;

  [[nodiscard]] TextLocation at() const { return {machine_->current_line(), machine_->current_column()}; }
  /// The thread commands the arm from now on. Throws BadArgument while another one does.
  void take(int thread);
  /// Asks again in each frame until there is a value. What is wrong ends the program.
  [[nodiscard]] Outcome ask(Act act);
  /// The same, once motions that the thread has given are over.
  [[nodiscard]] Outcome at_rest(int thread, Act act);
  [[nodiscard]] Outcome wait_for(int thread, double seconds, Value result = {});
  [[nodiscard]] Outcome move(int thread, MotionCommand command);
  [[nodiscard]] Outcome last(int thread, LastingCommand command, double seconds);
  [[nodiscard]] Outcome stop(int thread);
  [[nodiscard]] Outcome end_lasting(int thread);
  [[nodiscard]] Outcome write(int thread, Signal output, int number, double value);
  [[nodiscard]] Outcome read(int thread, Signal signal, int number);
  [[nodiscard]] MotionCommand command(const Arguments& a, MotionCommand::Kind kind, std::string_view word,
                                      std::size_t first) const;
  [[nodiscard]] MotionGoal goal(const Arguments& a, std::size_t i, bool may_be_joints) const;
  [[nodiscard]] Eigen::Isometry3d tool(const Arguments& a, std::size_t i) const;
  [[nodiscard]] kinematics::JointVector joints(const Arguments& a, std::size_t i) const;
  [[nodiscard]] ForceCommand force(const Arguments& a) const;

  Host& host_;
  Machine* machine_ = nullptr;
  Eigen::Isometry3d X_FT_;
  std::optional<ForceCommand> force_;
  bool freedrive_ = false;
  double payload_ = 0.0;
  std::vector<double> cog_ = {0.0, 0.0, 0.0};
  int owner_ = 0;  ///< thread that commands the arm; 0: none has
  double next_time_ = std::numeric_limits<double>::infinity();
};

/// Adds the functions of an arm, and `calls` without parameters. Programs that are only compiled need no arm.
void add_arm_functions(Library& library, ArmFunctions* arm, const std::set<std::string>& calls);

/// All functions of a program on an arm.
[[nodiscard]] Library arm_library(ArmFunctions* arm, const std::set<std::string>& calls);

}  // namespace takt::languages::urscript
