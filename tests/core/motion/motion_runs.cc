#include "tests/core/motion/motion_runs.h"
#include "core/motion/path_clock.h"

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

namespace takt::motion::test {

JointLimits random_limits(Random& random, const kinematics::Chain& chain) {
  const int n = chain.joint_count();
  JointLimits limits{.lower = chain.lower(),
                     .upper = chain.upper(),
                     .velocity = chain.velocity_limit().cwiseMin(10.0),
                     .acceleration = JointVector(n),
                     .jerk = JointVector(n)};
  for (int i = 0; i < n; ++i) {
    limits.acceleration[i] = random.uniform(3.0, 15.0);
    limits.jerk[i] = random.uniform(30.0, 400.0);
  }
  return limits;
}

Targets always(double target) {
  return [target] { return target; };
}

Targets at_random(Random& random, bool backwards) {
  struct State {
    double target = 1.0;
    int left = 0;
  };
  return [&random, backwards, state = std::make_shared<State>()] {
    if (state->left-- == 0) {
      const double pick = random.unit();
      state->target = pick < 0.25 ? 0.0 : pick < 0.6 ? 1.0 : random.uniform(backwards ? -1.0 : 0.0, 1.0);
      state->left = static_cast<int>(random.bits() % 600);
    }
    return state->target;
  };
}

void run(const Motion& motion, const Targets& target, int cycles_max,
         const std::function<void(const PathPoint&)>& emit) {
  PathClock clock(motion.clock, motion.law, true);
  for (int i = 0; i < 4; ++i) emit(follow(motion.law, clock.state()));
  for (int i = 0; i < cycles_max && (i == 0 || !clock.at_end()); ++i) {
    clock.update(target(), kPeriod);
    emit(follow(motion.law, clock.state()));
  }
  for (int i = 0; i < 4; ++i) emit(follow(motion.law, clock.update(0.0, kPeriod)));
}

std::vector<double> as_list(const JointVector& q) { return {q.data(), q.data() + q.size()}; }

takt::test::LimitOracle joint_oracle(const JointLimits& limits, double sample_error) {
  return {{.lower = as_list(limits.lower),
           .upper = as_list(limits.upper),
           .velocity = as_list(limits.velocity),
           .acceleration = as_list(limits.acceleration),
           .jerk = as_list(limits.jerk)},
          kPeriod,
          sample_error};
}

void expect_kept(const takt::test::LimitOracle& oracle, const char* what) {
  const auto say = [&](const char* name, const takt::test::LimitOracle::Worst& worst) {
    EXPECT_LE(worst.share, 1.0) << what << ": " << name << " of axis " << worst.axis << " at sample " << worst.sample;
  };
  say("velocity", oracle.velocity);
  say("acceleration", oracle.acceleration);
  say("jerk", oracle.jerk);
  EXPECT_LE(oracle.range_excess, 1e-9) << what;
}

}  // namespace takt::motion::test
