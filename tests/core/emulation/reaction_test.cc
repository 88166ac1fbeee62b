// The certificate of a site (row O7): an event at a slow sensor stops a slow arm not later than declared.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/device/arm.h"
#include "core/emulation/slow_arm.h"
#include "core/emulation/slow_force_torque.h"
#include "tests/support/arm_rig.h"

namespace takt::test {
namespace {

using emulation::SlowOptions;

struct Reaction {
  Nanoseconds longest = 0, declared = 0;
};

/// A push at a random cycle; in the cycle in which the core sees it the arm is told to move. Counted until the drives
/// are told so.
Reaction measure(const SlowOptions& arm_options, const SlowOptions& sensor_options) {
  Reaction reaction;
  Random random(3, "pushes");
  for (int run = 0; run < 200; ++run) {
    const auto rig = slowed(std::make_unique<FakeArmRig>(), arm_options);
    const auto touch = std::make_shared<FakeForceTorqueSensor>();
    emulation::SlowForceTorque wrist("wrist", touch, sensor_options, kMillisecond, static_cast<std::uint64_t>(run));
    device::Arm arm("arm", rig->description, rig->backend, kMillisecond);
    reaction.declared =
        wrist.timing().sample_age + rig->backend->timing().driver_delay + rig->backend->timing().dead_time;
    const auto pushed = 400 + static_cast<std::int64_t>(random.unit() * 50.0);
    std::int64_t seen = -1;
    for (std::int64_t k = 0; k < pushed + 300; ++k) {
      arm.begin_cycle(k, k * kMillisecond);
      device::WrenchSample sample;
      if (wrist.read(sample) && sample.wrench.force.x() > 1.0 && seen < 0) {
        seen = k;
        arm.hold();
      }
      if (seen >= 0) {
        // The set point of the cycle in which it is seen is the first to move: constant jerk.
        const double t = 1e-3 * static_cast<double>(k - seen + 1), j = 50.0;
        const auto n = arm.joint_count();
        arm.propose(device::JointVector::Constant(n, j * t * t * t / 6),
                    device::JointVector::Constant(n, j * t * t / 2), device::JointVector::Constant(n, j * t));
        EXPECT_FALSE(arm.check());
      }
      arm.hand_over();
      // The push comes after the core has looked.
      if (k == pushed) touch->sample.wrench.force.x() = 5.0;
      if (!rig->tap->told.empty() && rig->tap->told.back().q[0] > 0.0) {
        reaction.longest = std::max(reaction.longest, (k - pushed) * kMillisecond);
        break;
      }
    }
    EXPECT_GE(seen, 0);
  }
  return reaction;
}

TEST(SiteCertificate, O7_AReactionIsNeverLaterThanDeclaredAndTheBoundIsTight) {
  const SlowOptions ideal{.cycle = 4 * kMillisecond};
  const SlowOptions jittery{.cycle = 8 * kMillisecond,
                            .clock_offset = 99 * kSecond + 7,
                            .drift = 100e-6,
                            .wire = {.transport = 100'000, .jitter = 500'000}};
  for (const auto& [arm, sensor] :
       {std::pair(ideal, ideal), std::pair(jittery, ideal), std::pair(ideal, jittery), std::pair(jittery, jittery)}) {
    const Reaction reaction = measure(arm, sensor);
    // The drives are looked at once a cycle.
    EXPECT_LE(reaction.longest, reaction.declared + kMillisecond);
    EXPECT_GE(reaction.longest, reaction.declared - 3 * kMillisecond);
  }
}

}  // namespace
}  // namespace takt::test
