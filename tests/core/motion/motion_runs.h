#pragma once

#include <functional>

#include "core/base/random.h"
#include "core/motion/planner.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/limit_oracle.h"

namespace takt::motion::test {

inline constexpr double kPeriod = 1e-3;  ///< s

/// The chain's ranges and velocities with the given acceleration and jerk for each joint, drawn at random around those
/// of a small arm.
[[nodiscard]] JointLimits random_limits(Random& random, const kinematics::Chain& chain);

/// How the target of the path clock goes over a run; called once a cycle.
using Targets = std::function<double()>;
[[nodiscard]] Targets always(double target);
/// Cancel, pause, resume, override and (if `backwards`) running back, changing at random cycles.
[[nodiscard]] Targets at_random(Random& random, bool backwards);

/// Runs a motion cycle by cycle until it is at its end or `cycles_max` is over: `emit` gets the path point of each
/// cycle, the standing ones before and after included.
void run(const Motion& motion, const Targets& target, int cycles_max,
         const std::function<void(const PathPoint&)>& emit);

[[nodiscard]] takt::test::LimitOracle joint_oracle(const JointLimits& limits, double sample_error);
[[nodiscard]] std::vector<double> as_list(const JointVector& q);

/// Fails the running test if a limit is broken.
void expect_kept(const takt::test::LimitOracle& oracle, const char* what);

}  // namespace takt::motion::test
