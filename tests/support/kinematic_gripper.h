#pragma once

#include <algorithm>
#include <cmath>

#include "core/device/gripper.h"

namespace takt::test {

/// Fingers that go where they are told, with the speed they are told, until they meet the part.
class KinematicGripper final : public device::GripperBackend {
 public:
  KinematicGripper(double width, double part) : part_(part) {
    sample_.width = width;
    sample_.ready = true;
  }
  bool read(device::GripperSample& out) override {
    out = sample_;
    return sample_.sequence > 0;
  }
  void write(const device::GripperSetPoint& set_point) override {
    if (set_point.sequence == command_.sequence) return;
    command_ = set_point;
    sample_.state = device::GripperState::kMoving;
  }
  void advance() {
    ++sample_.sequence;
    sample_.stamp += kMillisecond;
    sample_.command = command_.sequence;
    if (sample_.state == device::GripperState::kHolding && part_ == 0.0) sample_.state = device::GripperState::kLost;
    const bool on_its_way =
        sample_.state == device::GripperState::kMoving || sample_.state == device::GripperState::kLost;
    if (!on_its_way) return;
    const double step = command_.speed * 1e-3, way = command_.width - sample_.width;
    sample_.width += std::clamp(way, -step, step);
    const bool met = part_ > 0.0 && way < 0.0 && sample_.width <= part_;
    if (met) sample_.width = part_;
    sample_.force = met ? command_.force : 0.0;
    if (met) sample_.state = device::GripperState::kHolding;
    const bool arrived = !met && std::abs(way) <= step && sample_.state == device::GripperState::kMoving;
    if (arrived) sample_.state = device::GripperState::kIdle;
  }
  /// What it holds, or would meet, is gone.
  void remove_part() { part_ = 0.0; }
  [[nodiscard]] const device::GripperSetPoint& command() const { return command_; }
  [[nodiscard]] double width() const { return sample_.width; }

 private:
  double part_;
  device::GripperSetPoint command_;
  device::GripperSample sample_;
};

}  // namespace takt::test
