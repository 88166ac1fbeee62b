#pragma once

#include "core/motion/path.h"
#include "hw/fri/protocol/packet.h"

namespace takt::hw::fri {

/// Goes from one commanded position to the next in one cycle of the interface: the parabola through the last two and
/// the next. A missing command is bridged with constant acceleration; by what the bridge was off when commands come
/// again the arm is told to be off, too, and that fades like a critically damped spring. One thread. Realtime: cyclic.
class Interpolator {
 public:
  /// @param cycle  s
  explicit Interpolator(double cycle);

  /// Stands there from now on.
  void stand(const Joints& q);
  /// A cycle begins that ends at `q`.
  void go(const Joints& q);
  /// A cycle begins whose command is missing.
  void bridge();
  /// Commands begin at `q`, which may be off by a little from where the arm stands.
  void start_from(const Joints& q) { wanted_.stand(q); }

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
    void shift(const Joints& off) {
      before += off;
      from += off;
      to += off;
    }
    /// The same acceleration once more.
    [[nodiscard]] Joints next() const { return 3.0 * to - 3.0 * from + before; }
  };

  void tell();
  void end_bridge(const Joints& q);
  void correct_bridge(const Joints& off);

  double cycle_;
  double fading_;  // share of an offset at rest that is left after a cycle
  Track told_;
  Track wanted_;  // as commanded, and as bridged
  int missing_ = 0;
};

}  // namespace takt::hw::fri
