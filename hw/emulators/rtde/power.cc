#include "hw/emulators/rtde/power.h"

#include <algorithm>

namespace takt::hw::rtde {

void PowerState::power_on() {
  if (mode_ != RobotMode::kPowerOff || safety_ == SafetyMode::kRobotEmergencyStop) return;
  mode_ = RobotMode::kPowerOn;
  goal_ = Goal::kIdle;
  due_ = now_ + kPowerOnTime;
}

void PowerState::power_off() {
  mode_ = RobotMode::kPowerOff;
  goal_ = Goal::kNone;
  if (safety_ == SafetyMode::kProtectiveStop) safety_ = SafetyMode::kNormal;
}

void PowerState::release_brakes() {
  if (mode_ == RobotMode::kRunning) return;
  power_on();
  if (mode_ == RobotMode::kIdle) due_ = now_ + kBrakeTime;
  if (mode_ != RobotMode::kPowerOff) goal_ = Goal::kRunning;
}

void PowerState::protective_stop() {
  if (!allows_motion(safety_)) return;
  safety_ = SafetyMode::kProtectiveStop;
  stopped_at_ = now_;
  unlock_asked_ = false;
}

bool PowerState::unlock() {
  if (safety_ != SafetyMode::kProtectiveStop) return true;
  if (now_ - stopped_at_ < kUnlockAfter) return false;
  safety_ = SafetyMode::kNormal;
  return true;
}

void PowerState::emergency_stop(bool pressed) {
  if (pressed) {
    power_off();
    safety_ = SafetyMode::kRobotEmergencyStop;
  } else if (safety_ == SafetyMode::kRobotEmergencyStop) {
    safety_ = SafetyMode::kNormal;
  }
}

void PowerState::safeguard_stop(bool open) {
  if (open && allows_motion(safety_)) {
    safety_ = SafetyMode::kSafeguardStop;
  } else if (!open && safety_ == SafetyMode::kSafeguardStop) {
    safety_ = SafetyMode::kNormal;
  }
}

void PowerState::restart_safety() {
  power_off();
  safety_ = SafetyMode::kNormal;
}

void PowerState::step(Nanoseconds now) {
  now_ = now;
  if (unlock_asked_ && now_ - stopped_at_ >= kUnlockLater) {
    unlock_asked_ = false;
    if (safety_ == SafetyMode::kProtectiveStop) safety_ = SafetyMode::kNormal;
  }
  if (goal_ == Goal::kNone || now_ < due_) return;
  if (mode_ == RobotMode::kPowerOn) {
    mode_ = RobotMode::kIdle;
    due_ = now_ + kBrakeTime;
    if (goal_ == Goal::kIdle) goal_ = Goal::kNone;
  } else if (mode_ == RobotMode::kIdle) {
    mode_ = RobotMode::kRunning;
    goal_ = Goal::kNone;
  }
}

}  // namespace takt::hw::rtde
