#pragma once

#include <string>

#include "hw/rtde/field.h"

namespace takt::hw::rtde {

/// Which half of the general registers the driver uses; the upper one came with 3.9 and 5.3, the lower one is shared
/// with field buses.
enum class RegisterHalf : int { kLower = 0, kUpper = 24 };

/// What the driver tells the program on the controller, in an integer register.
enum class ControlMode : int { kIdle = 0, kPosition = 1, kFreedrive = 4, kEnd = 9 };
/// What the program says of itself.
enum class ProgramState : int { kNone = 0, kReady = 1, kStreaming = 2, kStopped = 3, kFreedrive = 4, kEnded = 5 };

/// Which registers carry what, from the first one of the half on.
struct RegisterLayout {
  RegisterHalf half = RegisterHalf::kUpper;
  [[nodiscard]] int first() const { return static_cast<int>(half); }
  // Inputs, integer: number of the package, mode. Inputs, real: six joint positions.
  [[nodiscard]] std::string sequence_in() const { return name("input_int_register_", 0); }
  [[nodiscard]] std::string mode_in() const { return name("input_int_register_", 1); }
  [[nodiscard]] std::string joint_in(int i) const { return name("input_double_register_", i); }
  // Outputs, integer: state of the program, number of the package that it followed last, its mark.
  [[nodiscard]] std::string state_out() const { return name("output_int_register_", 0); }
  [[nodiscard]] std::string sequence_out() const { return name("output_int_register_", 1); }
  [[nodiscard]] std::string mark_out() const { return name("output_int_register_", 2); }

 private:
  [[nodiscard]] std::string name(const char* kind, int i) const { return kind + std::to_string(first() + i); }
};

/// How the program follows.
struct ControlProgram {
  RegisterLayout registers;
  Version version;            ///< of the controller
  double lookahead = 0.03;    ///< s, of servoj(): 0.03 to 0.2
  double gain = 2000.0;       ///< of servoj(): 100 to 2000
  double deceleration = 4.0;  ///< rad/s^2, of the stop when packages are missing
  int bridged_cycles = 3;     ///< that it goes on for without a package
  double watchdog_hz = 10.0;  ///< below this rate of packages the controller stops the program
  int mark = 0;               ///< tells programs of two drivers apart

  /// s, the lag with which servoj() follows, as it is taken into account (docs/hardware-ur.md).
  [[nodiscard]] double lag() const { return lookahead * 300.0 / gain; }
  /// Share of the distance to its goal that servoj() covers in one control cycle.
  [[nodiscard]] double share() const;
  /// The text that is uploaded. Realtime: setup.
  [[nodiscard]] std::string text() const;
};

}  // namespace takt::hw::rtde
