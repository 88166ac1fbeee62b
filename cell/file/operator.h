#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/form_of.h"
#include "core/device/channel.h"
#include "core/device/emergency_stop.h"
#include "core/rcc/control_core.h"

namespace takt::cell {

/// What an operator does at a time that the scenario names ("operator", docs/how-to/operator-and-faults.md).
struct OperatorAction {
  enum class Kind { kPause, kResume, kOverride, kCancel, kAbort, kWrite };
  Kind kind = Kind::kPause;
  std::string pointer;
  std::string step;        ///< the time counts from the first begin of a step of this name; empty: from the start
  double after_s = 0.0;    ///< s
  double override_ = 1.0;  ///< share of the planned speed, 0 to 1
  std::string channel;     ///< of kWrite
  std::string value;       ///< of kWrite, as JSON text
  double held_s = 0.0;     ///< of kWrite, s: written again and again for so long, as a hand on a stick does
};

/// An entry of "operator": {"at_s" or "at_step" with "after_s", "do", ...}.
[[nodiscard]] const FormOf<OperatorAction>& operator_form();

/// Channels that are not there or carry another type; steps that the program does not have.
/// @param steps  names of the program's steps; nothing: nobody knows them before the run (a program in C++)
[[nodiscard]] Diagnostics check_operator(const std::vector<OperatorAction>& actions, rcc::ControlCore& core,
                                         const std::optional<std::vector<std::string>>& steps);

/// What an operator may ask of a running program, whatever it is written in.
struct OperatedProgram {
  std::function<void(bool held)> hold;  ///< no step begins while it is held
  std::function<void()> cancel;         ///< ends in order
};

/// Acts on a running program: pause and resume, speed override, cancel, abort, values for channels. Whoever sits at a
/// panel calls the same functions as a script does. Thread: the one that steps the core.
class Operator {
 public:
  /// Channel that scales the rate of all planned motions, 0 to 1. It begins with SiteDevices::speed_override().
  static constexpr std::string_view kOverride = "operator/override";
  using Note = std::function<void(std::string_view name, std::string_view text)>;

  /// @param button  the cell's emergency stop; null: it has none
  Operator(const std::vector<OperatorAction>& script, rcc::ControlCore& core, const device::EmergencyStop* button,
           OperatedProgram program, Note note);

  /// Does what is due; before each cycle. A program ends with an emergency stop: nothing of it goes on after the reset
  /// (row S4).
  void before_cycle();
  /// A step has begun, for times that count from it.
  void step_begun(std::string_view step);

  /// All planned motions come to rest on their paths, no step begins.
  void pause();
  void resume();
  /// From now on motions run at this share of their planned speed.
  void set_override(double share);
  void cancel();
  /// Every net ends, devices stop; the program ends with it.
  void abort();

  [[nodiscard]] bool paused() const { return paused_; }
  [[nodiscard]] bool cancelled() const { return cancelled_; }
  /// Why the program cannot have come to its end: an abort, an emergency stop; empty: nothing of that.
  [[nodiscard]] const std::string& broken_off() const { return broken_off_; }

 private:
  struct PendingCommand {
    const OperatorAction* action;
    std::int64_t cycle;  ///< -1: not known yet, its step has not begun
  };
  /// A value that a hand holds.
  struct HeldValue {
    device::Channel* channel;
    std::optional<device::ChannelValue> value;  ///< nothing: null
    std::int64_t next, last;                    ///< cycles of the next and of the last time
  };
  [[nodiscard]] std::int64_t cycles(double seconds) const;
  void break_off(const std::string& why);
  void act(const OperatorAction& action);
  void write(const OperatorAction& action);
  void write_held(std::int64_t now);
  void send();

  rcc::ControlCore& core_;
  const device::EmergencyStop* button_;
  OperatedProgram program_;
  Note note_;
  std::vector<PendingCommand> due_;
  std::vector<HeldValue> held_;
  double override_;
  bool paused_ = false, cancelled_ = false;
  std::string broken_off_;
};

}  // namespace takt::cell
