#include "core/motion/stop_range.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/motion/online_generator.h"

namespace takt::motion {
namespace {

/// Against the generator's own way to rest, sampled finely.
TEST(StopRange, IsWhereTheFastestStopComes) {
  Random random(1);
  OnlineGenerator generator(1, OnlineGenerator::Synchronization::kNone);
  for (int i = 0; i < 300; ++i) {
    const double a_max = random.uniform(0.5, 5.0), jerk = random.uniform(5.0, 100.0);
    const double q = random.uniform(-1, 1), dq = random.uniform(-2, 2), ddq = random.uniform(-a_max, a_max);
    const auto one = [](double x) { return JointVector(JointVector::Constant(1, x)); };
    generator.start({one(q), one(dq), one(ddq)});
    double low = q, high = q;
    for (int k = 0; k < 200000; ++k) {
      const auto status = generator.follow_velocity(one(0.0), {one(1.0), one(a_max), one(jerk)}, 1e-4);
      low = std::min(low, generator.state().q[0]);
      high = std::max(high, generator.state().q[0]);
      if (status == OnlineGenerator::Status::kArrived) break;
    }
    const StopRange range = stop_range(q, dq, ddq, a_max, jerk);
    EXPECT_NEAR(range.lowest, low, 1e-4) << i;
    EXPECT_NEAR(range.highest, high, 1e-4) << i;
    EXPECT_LE(range.lowest, low + 1e-9) << i;
    EXPECT_GE(range.highest, high - 1e-9) << i;
  }
}

}  // namespace
}  // namespace takt::motion
