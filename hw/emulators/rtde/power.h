#pragma once

#include "core/base/time.h"
#include "hw/rtde/modes.h"

namespace takt::hw::rtde {

/// Power, brakes and safety of an emulated controller, on its own time. One thread.
class PowerState {
 public:
  /// How long the changes take. A real one needs about ten times as long.
  static constexpr Nanoseconds kPowerOnTime = 500 * kMillisecond, kBrakeTime = 300 * kMillisecond;
  /// A protective stop can be unlocked after this time.
  static constexpr Nanoseconds kUnlockAfter = 5 * kSecond;
  /// When an unlock that was asked for on the primary interface takes effect, counted from the stop.
  static constexpr Nanoseconds kUnlockLater = kSecond;

  explicit PowerState(bool running) : mode_(running ? RobotMode::kRunning : RobotMode::kPowerOff) {}

  [[nodiscard]] RobotMode mode() const { return mode_; }
  [[nodiscard]] SafetyMode safety() const { return safety_; }
  [[nodiscard]] bool can_move() const { return mode_ == RobotMode::kRunning && allows_motion(safety_); }
  /// The drives hold the arm.
  [[nodiscard]] bool drives_on() const { return mode_ == RobotMode::kRunning; }

  void power_on();
  void power_off();
  /// Powers on first where that is needed.
  void release_brakes();
  void protective_stop();
  /// @return false: not before kUnlockAfter.
  bool unlock();
  /// As soon as kUnlockLater allows.
  void unlock_later() { unlock_asked_ = true; }
  /// Pressed, or pulled out again: then the power stays off.
  void emergency_stop(bool pressed);
  void safeguard_stop(bool open);
  /// After a fault or violation: power off, and normal.
  void restart_safety();

  void step(Nanoseconds now);

 private:
  enum class Goal { kNone, kIdle, kRunning };

  RobotMode mode_;
  SafetyMode safety_ = SafetyMode::kNormal;
  Goal goal_ = Goal::kNone;
  Nanoseconds now_ = 0, due_ = 0, stopped_at_ = 0;
  bool unlock_asked_ = false;
};

}  // namespace takt::hw::rtde
