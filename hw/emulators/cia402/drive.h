#pragma once

#include <cstdint>
#include <optional>

#include "core/base/time.h"
#include "hw/cia402/protocol/drive_state.h"
#include "hw/emulators/cia402/dictionary.h"

namespace takt::hw::cia402 {

/// What an emulated drive is like, and the joint that it moves.
struct DriveOptions {
  std::uint32_t encoder_increments = 1u << 20;  ///< in a turn of the motor
  std::uint32_t gear = 100;                     ///< turns of the motor in one of the joint
  std::uint32_t rated_torque_mNm = 1000;        ///< of the motor
  double lower = -3.0, upper = 3.0;             ///< range of the joint, rad
  double velocity = 2.0;                        ///< limit of the joint, rad/s
  int bridged = 3;                              ///< cycles without set point or SYNC; with one more it stops by itself
};

/// Where a joint is, or is told to be.
struct AxisPoint {
  double q = 0.0, dq = 0.0, ddq = 0.0;  ///< rad, rad/s, rad/s2
};

/// A drive in mode CSP: state machine, interpolation from one set point to the next, its own stops and faults. The
/// objects of CiA 402 are in the dictionary of its node. Realtime: cyclic but for the constructor.
class Drive {
 public:
  Drive(Dictionary& objects, const DriveOptions& options);

  // -- The machine's side
  /// @param powered  the joint follows set points @param torque  of the joint, Nm
  void measure(const AxisPoint& measured, double torque, bool powered);
  /// Where the joint is told to be.
  [[nodiscard]] AxisPoint at(Nanoseconds now) const;
  /// Its voltage was switched off in motion since the last call: the brakes have to close.
  [[nodiscard]] bool take_brakes();
  /// At the last SYNC its master wanted it on, and the joint did not follow set points: the brakes may open.
  [[nodiscard]] bool waits_for_power() const { return waits_; }

  // -- The bus's side
  /// The target position was written: the set point counts from the next cycle on.
  void take_outputs() { fresh_ = true; }
  /// SYNC has come.
  void begin_cycle(Nanoseconds now);
  /// Time goes on. Where SYNC is missing a cycle begins by the drive's own clock.
  void pass(Nanoseconds now);
  /// Time during which the joint cannot be measured does not count.
  void suspend(Nanoseconds now);
  /// Writes status, position and the like.
  void report();
  /// A fault: brakes the joint by itself, then switches off.
  void fail(std::uint16_t code, Nanoseconds now);
  /// A fault that has not been reported on the bus yet; 0: one was reset.
  [[nodiscard]] std::optional<std::uint16_t> take_error();
  [[nodiscard]] DriveState state() const { return state_; }

 private:
  [[nodiscard]] double increments_per_rad() const;
  [[nodiscard]] Nanoseconds period() const;
  [[nodiscard]] bool enabled() const { return state_ == DriveState::kOperationEnabled; }
  [[nodiscard]] bool braking() const {
    return state_ == DriveState::kQuickStopActive || state_ == DriveState::kFaultReactionActive;
  }
  void follow_control(Nanoseconds now);
  void enter(DriveState state, Nanoseconds now);
  [[nodiscard]] AxisPoint end_of_cycle() const;
  void next_set_point(Nanoseconds now);
  void take_set_point(Nanoseconds now);
  void bridge();
  void start_ramp(Nanoseconds now);
  void end_ramp(Nanoseconds now);
  void hold(double q);
  [[nodiscard]] double ramp_time() const;

  Dictionary& objects_;
  DriveOptions options_;
  DriveState state_ = DriveState::kSwitchOnDisabled;
  std::uint16_t control_before_ = 0;
  AxisPoint measured_;
  double torque_ = 0.0;
  bool powered_ = false, has_measured_ = false, brakes_ = false, waits_ = false;
  std::optional<std::uint16_t> error_;
  AxisPoint from_, to_;                 // of the cycle that runs; after a quick stop began: from_ alone
  Nanoseconds begin_ = 0;               // of that cycle, or of the ramp
  bool in_step_ = false;                // begin_ is that of a SYNC
  bool fresh_ = false;                  // a set point has come in this cycle
  int missing_ = 0, missing_sync_ = 0;  // cycles in a row
};

}  // namespace takt::hw::cia402
