#pragma once

#include "core/motion/path.h"
#include "hw/fri/protocol/packet.h"

namespace takt::hw::fri {

/// Goes from one commanded position to the next in one cycle of the interface: the parabola through the last two and
/// the next. A missing command is bridged with constant acceleration; what comes after it is approached without a step
/// in velocity or acceleration. One thread. Realtime: cyclic.
class Interpolator {
 public:
  /// @param cycle  s
  explicit Interpolator(double cycle) : cycle_(cycle) {}

  /// Stands there from now on.
  void stand(const Joints& q);
  /// A cycle begins that ends at `q`.
  void go(const Joints& q);
  /// A cycle begins whose command is missing.
  void bridge();
  /// The next command may be elsewhere by a little: it is approached as after a gap.
  void expect_step() { missing_ = 1; }

  /// `time` s after the cycle began.
  [[nodiscard]] motion::JointSample at(double time) const;
  /// Where the cycle began, and where it ends.
  [[nodiscard]] const Joints& begin() const { return from_; }
  [[nodiscard]] const Joints& end() const { return to_; }
  /// As told from one instant to the next, at the beginning of this cycle: rad/s over the cycle, rad/s^2.
  [[nodiscard]] Joints velocity() const { return (to_ - from_) / cycle_; }
  [[nodiscard]] Joints acceleration() const { return (to_ - 2.0 * from_ + before_) / (cycle_ * cycle_); }
  /// Commands missing in a row.
  [[nodiscard]] int missing() const { return missing_; }

 private:
  [[nodiscard]] Joints next() const { return 3.0 * to_ - 3.0 * from_ + before_; }
  void shift(const Joints& to);
  [[nodiscard]] double share_of_gap() const;

  double cycle_;
  Joints before_ = Joints::Zero(), from_ = Joints::Zero(), to_ = Joints::Zero();
  int missing_ = 0;
  Joints gap_ = Joints::Zero();  // between the first command after missing ones and where these had led
  int since_gap_ = 0, gap_cycles_ = 0;
};

}  // namespace takt::hw::fri
