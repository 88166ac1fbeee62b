// How far and how long an arm goes on after a stop on its path, beside what its limits need (found by a fine search)
// and what the path clock alone would take, whose bounds are those of the worst location of the path. Three arms; PTP
// and LIN at full speed, a probe at 5 mm/s; several overrides. Ways in mm or rad of the axis that goes furthest, times
// in ms.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/device/device_file.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/motion/path_clock.h"
#include "core/motion/planner.h"
#include "tests/support/shortest_stop.h"

namespace takt {
namespace {

using motion::Motion;

constexpr double kPeriod = 1e-3;

template <class T>
T value_or_exit(Result<T> result) {
  if (result) return *std::move(result);
  std::fprintf(stderr, "run from the root of the repository\n%s", result.error().to_string().c_str());
  std::exit(2);
}

/// A motion, and what its s is worth: mm or rad.
struct Case {
  const char* name;
  Motion motion;
  double scale;
  const char* unit;
};

struct Stop {
  double s, time;
};

Stop stop(const Motion& motion, bool with_table, double from, double rate) {
  motion::ClockBounds bounds = motion.clock;
  if (!with_table) bounds.stop.clear();
  motion::PathClock clock(bounds, motion.law, false);
  clock.reset({.tau = from, .rate = rate});
  double time = 0.0;
  for (; !clock.at_rest(); time += kPeriod) clock.update(0.0, kPeriod);
  return {.s = motion.law.at(clock.state().tau).s, .time = time};
}

void print(const std::string& arm_name, const test::ShortestStop& shortest, const Case& one, double at, double rate) {
  const double from = at * one.motion.duration();
  const motion::LawPoint law = one.motion.law.at(from);
  const auto least = shortest.from(from, rate);
  const Stop usual = stop(one.motion, false, from, rate), table = stop(one.motion, true, from, rate);
  const auto way = [&](double s) { return one.scale * (s - law.s); };
  std::printf("%-9s %-16s %4.0f %% %5.2f %9.4g %s/s | %8.4g %8.4g %8.4g %s | %6.1f %6.1f %6.1f ms | %5.2f %5.2f\n",
              arm_name.c_str(), one.name, 100 * at, rate, one.scale * law.ds * rate, one.unit, way(least.s),
              way(table.s), way(usual.s), one.unit, 1e3 * least.time, 1e3 * table.time, 1e3 * usual.time,
              way(table.s) / way(least.s), way(usual.s) / way(least.s));
}

void measure(const std::string& name) {
  const auto arm = value_or_exit(device::read_arm("models/" + name));
  const motion::ArmModel model{.chain = *arm->chain,
                               .inverse = arm->inverse.get(),
                               .limits = arm->limits,
                               .cartesian = arm->cartesian,
                               .load = motion::DriveLoad{.armature = arm->armature}};
  const motion::MotionOptions options{.load = model.load};
  const Eigen::Isometry3d X_home = arm->chain->forward(arm->home);
  const auto shifted = [&](double y, double z) -> Eigen::Isometry3d { return Eigen::Translation3d(0, y, z) * X_home; };

  motion::JointVector q_goal = arm->home;
  q_goal[0] += 2.0;
  q_goal[1] += 0.5;
  motion::MotionOptions slow = options;
  slow.linear_velocity = 0.005;
  const Case cases[] = {
      {"PTP", value_or_exit(plan_ptp(*arm->chain, arm->limits, arm->home, q_goal, options)), 2.0, "rad"},
      {"LIN",
       value_or_exit(plan_lin(*arm->chain, *arm->inverse, arm->limits, arm->cartesian, arm->home, shifted(0.4, 0.0), {},
                              options)),
       400.0, "mm"},
      {"LIN 5 mm/s",
       value_or_exit(
           plan_lin(*arm->chain, *arm->inverse, arm->limits, arm->cartesian, arm->home, shifted(0.0, -0.02), {}, slow)),
       20.0, "mm"}};
  for (const Case& one : cases) {
    const test::ShortestStop shortest(model, one.motion);
    for (const double at : {0.15, 0.5, 0.7}) print(name, shortest, one, at, 1.0);
    for (const double rate : {0.5, 0.1}) print(name, shortest, one, 0.5, rate);
  }
}

}  // namespace
}  // namespace takt

int main() {
  std::printf(
      "arm       motion           where  rate     speed       | least, now, clock alone          | the same in "
      "time          | over the least\n");
  for (const char* name : {"lwr4plus", "ur5", "tx90"}) takt::measure(name);
  return 0;
}
