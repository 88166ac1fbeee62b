#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/device/arm.h"
#include "core/motion/time_law.h"
#include "tests/hw/fri/twin_rig.h"

namespace takt::test {

/// A core with one arm in front of a twin, one cycle at a time, that swings all joints to and fro.
class FriBench {
 public:
  static constexpr Nanoseconds kPeriod = kMillisecond;

  explicit FriBench(const hw::fri::TwinOptions& options = {}, std::uint64_t seed = 11)
      : rig(options, seed), arm("arm", rig.description, rig.backend, kPeriod) {
    rig.arm->keep = false;
    rig.tap->told.reserve(1 << 16);
  }

  [[nodiscard]] hw::fri::Twin& twin() { return *rig.twin; }
  [[nodiscard]] const hw::fri::Controller& controller() { return twin().emulator().controller(); }
  [[nodiscard]] const hw::fri::ClientReport& report() { return twin().client().report(); }
  [[nodiscard]] bool following() const { return arm.phase() == device::Arm::Phase::kFollowing; }
  [[nodiscard]] const device::JointVector& told() const { return rig.tap->told.back().q; }

  /// One cycle of the core; a swing goes on if the arm follows.
  void cycle() {
    arm.begin_cycle(k, k * kPeriod);
    if (arm.lost() && arm.held()) {
      arm.stop();
      ++nets_ended;
    }
    if (following()) propose();
    if (const auto trip = arm.check()) {
      ADD_FAILURE() << trip->view();
      arm.stop();
    }
    arm.hand_over();
    if (!keep_told) rig.tap->told.erase(rig.tap->told.begin(), rig.tap->told.end() - 1);
    ++k;
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// @return false: it did not become so
  template <class Condition>
  bool until(const Condition& condition, int most = 3000) {
    for (int i = 0; i < most && !condition(); ++i) cycle();
    return condition();
  }
  bool becomes_ready(int most = 3000) {
    return until([&] { return arm.phase() == device::Arm::Phase::kFrozen; }, most);
  }
  /// A net takes the arm: from now on it swings around where it stands.
  void start(double radians = 0.3) {
    ASSERT_FALSE(arm.refusal()) << arm.refusal()->view();
    arm.hold();
    begin = k;
    from = arm.set_point().q;
    way = device::JointVector::Constant(hw::fri::kJoints, radians);
    radians = std::abs(radians);
    const auto& limits = arm.description().limits;
    law = motion::TimeLaw::rest_to_rest({0.6 * limits.velocity.minCoeff() / radians,
                                         0.6 * limits.acceleration.minCoeff() / radians,
                                         0.6 * limits.jerk.minCoeff() / radians});
  }

  FriTwinRig rig;
  device::Arm arm;
  std::int64_t k = 0;
  int nets_ended = 0;
  bool keep_told = true;

 private:
  void propose() {
    const double t = to_seconds((k - begin) * kPeriod), T = law.duration();
    const double phase = t - std::floor(t / (2.0 * T)) * 2.0 * T;
    const motion::LawPoint out = law.at(std::min(phase, T)), back = law.at(std::max(0.0, phase - T));
    arm.propose(from + (out.s - back.s) * way, (out.ds - back.ds) * way, (out.dds - back.dds) * way);
  }

  std::int64_t begin = 0;
  device::JointVector from, way;
  motion::TimeLaw law;
};

}  // namespace takt::test
