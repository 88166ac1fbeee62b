#pragma once

#include <array>
#include <optional>

#include "core/base/time.h"
#include "core/kinematics/types.h"

namespace takt::device {

using kinematics::JointVector;

/// A joint that is not where its set points have been.
struct FollowingError {
  int joint = 0;
  double error = 0.0;  ///< rad or m, beyond all set points of the window
};

/// Watches whether a machine follows what it is sent: each measured position must lie among the set points of a window
/// before it, by a bound. The window covers all delays between the core and the machine, so that a delay is no error;
/// an arm that stands still, jumps or drifts leaves it at once. Fixed capacity. Realtime: cyclic.
class FollowingMonitor {
 public:
  /// @param bound   largest following error, rad or m, the same for all joints
  /// @param window  age of the oldest set point at which the machine may still be
  FollowingMonitor(double bound, Nanoseconds window, Nanoseconds period);

  /// A set point was sent, one per cycle.
  void sent(const JointVector& q);
  /// Set points are followed no longer, or in a way that gives way: the window begins anew.
  void clear();
  /// The largest error beyond the bound; nothing while the window is not full. @param q  measured, rad or m
  [[nodiscard]] std::optional<FollowingError> check(const JointVector& q) const;
  [[nodiscard]] double bound() const { return bound_; }

 private:
  static constexpr int kBlocks = 16;  // the window moves on by a block

  double bound_;
  int block_length_;
  std::array<JointVector, kBlocks + 1> min_, max_;  // per block; the newest is being filled
  int newest_ = 0;
  int filled_ = 0;    // whole blocks before the newest
  int in_block_ = 0;  // set points in the newest block
};

}  // namespace takt::device
