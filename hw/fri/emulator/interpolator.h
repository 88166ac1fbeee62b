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
  [[nodiscard]] const Joints& begin() const { return told_.from; }
  [[nodiscard]] const Joints& end() const { return told_.to; }
  /// As told from one instant to the next, at the beginning of this cycle: rad/s over the cycle, rad/s^2.
  [[nodiscard]] Joints velocity() const { return (told_.to - told_.from) / cycle_; }
  [[nodiscard]] Joints acceleration() const { return (told_.to - 2.0 * told_.from + told_.before) / (cycle_ * cycle_); }
  /// Commands missing in a row.
  [[nodiscard]] int missing() const { return missing_; }

 private:
  /// Three positions, a cycle apart.
  struct Track {
    Joints before = Joints::Zero(), from = Joints::Zero(), to = Joints::Zero();

    void stand(const Joints& q) { before = from = to = q; }
    void go(const Joints& q) {
      before = from;
      from = to;
      to = q;
    }
    /// The same acceleration once more.
    [[nodiscard]] Joints next() const { return 3.0 * to - 3.0 * from + before; }
  };

  double cycle_;
  Track told_;
  int missing_ = 0;
  // After a gap: what was told in it goes on with its acceleration, and what is commanded takes over by and by.
  Track bridge_;
  int since_gap_ = 0, gap_cycles_ = 0;
};

}  // namespace takt::hw::fri
