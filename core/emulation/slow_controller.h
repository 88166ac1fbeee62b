#pragma once

#include <array>
#include <cstdint>

#include "core/device/arm_agent.h"
#include "core/device/brake_ramp.h"
#include "core/emulation/state_hash.h"
#include "core/motion/limits.h"

namespace takt::emulation {

/// The interpolator of a robot controller with a command interface in its own cycle: at each of its instants it takes
/// the set point for the next one and goes there in one cycle, by the polynomial of fifth degree. Without a set point
/// it goes on with constant acceleration for a few cycles; then it stops within its limits by itself and takes set
/// points again when a whole series of answers has come in time. All on the device's clock. Realtime: cyclic.
class SlowController {
 public:
  SlowController(const motion::JointLimits& limits, Nanoseconds cycle, int answer_timeout_cycles)
      : limits_(limits), cycle_(cycle), answer_timeout_cycles_(answer_timeout_cycles) {}

  /// Stands at `q` and waits for set points.
  void stand(const kinematics::JointVector& q);
  /// An answer has come.
  void take(const device::ArmAnswer& answer, Nanoseconds resampled);
  /// A cycle begins. @return false if it had to go without a set point.
  bool begin_cycle(Nanoseconds instant);

  /// Where it tells the joints to be, between the instants too.
  [[nodiscard]] motion::JointSample at(Nanoseconds device_time) const;
  /// Where it is going.
  [[nodiscard]] const motion::JointSample& goal() const { return to_; }
  /// The core's time of the set point for the end of this cycle; -1 without one.
  [[nodiscard]] Nanoseconds resampled() const { return resampled_; }
  /// Took no set points because too many answers were missing.
  [[nodiscard]] bool timed_out() const { return timed_out_; }
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

  void add_state(StateHash& hash) const;

 private:
  struct Pending {
    Nanoseconds instant = -1, resampled = -1;
    motion::JointSample state;
  };

  const Pending* find(Nanoseconds instant) const;
  void bridge(Nanoseconds instant);

  motion::JointLimits limits_;
  Nanoseconds cycle_;
  int answer_timeout_cycles_;
  std::array<Pending, 8> pending_;
  std::size_t next_pending_ = 0;
  motion::JointSample from_, to_;
  Nanoseconds begin_ = 0;  // instant of from_
  Nanoseconds resampled_ = -1;
  bool commanded_ = false;  // has ever had a set point since it stood
  int missing_ = 0;         // in a row
  int in_time_ = 0;         // in a row, while timed out
  bool timed_out_ = false;
  device::BrakeRamp ramp_;
  Nanoseconds ramp_begin_ = 0;
  std::uint64_t missed_ = 0;
};

}  // namespace takt::emulation
