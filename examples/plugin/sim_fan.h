#pragma once

#include <cmath>
#include <optional>

#include "core/base/time.h"
#include "fan.h"
#include "sim/model/device.h"

namespace fan {

/// A fan that follows its set point with a delay of first order. Thread: the one that steps the world.
class SimFan final : public takt::sim::SimDevice, public FanBackend {
 public:
  SimFan(double time_constant, double speed) : time_constant_(time_constant), speed_(speed), wanted_(speed) {}

  std::optional<double> read() override { return speed_; }
  void write(double speed) override { wanted_ = speed; }
  /// Something is between the blades: it stands, whatever is wanted.
  void block(bool blocked) { blocked_ = blocked; }

  void start(const mjData_&) override {}
  void actuate(mjData_&, const takt::sim::Substep&) override {}
  void measure(const mjData_&, takt::Nanoseconds now) override {
    const double dt = takt::to_seconds(now - now_);
    speed_ += (1.0 - std::exp(-dt / time_constant_)) * (wanted_ - speed_);
    if (blocked_) speed_ = 0.0;
    now_ = now;
  }
  void stream(takt::sim::StateStream& state) override {
    state(speed_);
    state(wanted_);
    state(now_);
    state(blocked_);
  }

 private:
  double time_constant_;
  double speed_, wanted_;  // rad/s
  takt::Nanoseconds now_ = 0;
  bool blocked_ = false;
};

}  // namespace fan
