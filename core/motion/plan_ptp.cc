#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/motion/clock_bounds.h"
#include "core/motion/plan_checks.h"
#include "core/motion/planner.h"
#include "core/motion/torque_profile.h"

namespace takt::motion {
namespace {

/// The longest way of a joint measured by its limit: a bound on the path parameter is one over it.
double longest(const JointVector& way, const JointVector& limit) {
  return (way.array().abs() / limit.array()).maxCoeff();
}

ClockBounds clock_for(const TimeLaw& law, double way_by_acceleration, double way_by_jerk) {
  ClockSearch search;
  for (const LawPoint& at : instants(law, kPartsPerSegment)) {
    search.add({.first_by_acceleration = way_by_acceleration * std::abs(at.ds),
                .second_by_acceleration = way_by_acceleration * std::abs(at.dds),
                .first_by_jerk = way_by_jerk * std::abs(at.ds),
                .second_by_jerk = way_by_jerk * std::abs(at.dds),
                .third_by_jerk = way_by_jerk * std::abs(at.ddds)});
  }
  ClockBounds bounds = search.bounds();
  const std::array loads = {StopLoad{.first = way_by_acceleration, .acceleration = 1.0},
                            StopLoad{.first = way_by_jerk, .jerk = 1.0}};
  bounds.stop = {stop_cell(loads, 0.0, 1.0)};
  return bounds;
}

/// The torques along a joint line, at nodes between which no joint turns by more than 0.1 rad.
TorqueProfile torques_on(const kinematics::Chain& chain, const DriveLoad& load, const JointVector& q_start,
                         const JointVector& way) {
  constexpr double kStep = 0.1, kMost = 128.0;
  const int steps = static_cast<int>(std::clamp(std::ceil(way.cwiseAbs().maxCoeff() / kStep), 4.0, kMost));
  TorqueProfile profile(chain, load);
  for (int k = 0; k <= steps; ++k) {
    const double s = static_cast<double>(k) / steps;
    profile.add(s, q_start + s * way, way, JointVector::Zero(way.size()));
  }
  return profile;
}

}  // namespace

Result<Motion> plan_ptp(const kinematics::Chain& chain, const JointLimits& limits, const JointVector& q_start,
                        const JointVector& q_goal, const MotionOptions& options) {
  Diagnostics diagnostics;
  check_limits(chain, limits, diagnostics);
  check_options(options, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  check_configuration(chain, limits, q_start, "/start", diagnostics);
  check_configuration(chain, limits, q_goal, "/goal", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  Motion motion{.path = JointLine{.q_start = q_start, .q_goal = q_goal},
                .law = {},
                .clock = {},
                .q_start = q_start,
                .q_goal = q_goal,
                .shares = {{.velocity = options.velocity, .acceleration = options.acceleration}}};
  const JointVector way = q_goal - q_start;
  constexpr double kNoWay = 1e-12;  // rad or m: less is only the rounding of the inputs
  if (way.cwiseAbs().maxCoeff() < kNoWay) return motion;
  const double by_velocity = longest(way, limits.velocity);
  const double by_acceleration = longest(way, limits.acceleration);
  const double by_jerk = longest(way, limits.jerk);
  motion.law = TimeLaw::rest_to_rest({.velocity = kLawShareOfVelocity * options.velocity / by_velocity,
                                      .acceleration = kLawShareOfAcceleration * options.acceleration / by_acceleration,
                                      .jerk = kLawShareOfJerk * options.acceleration / by_jerk});
  if (!options.load) {
    motion.clock = clock_for(motion.law, by_acceleration, by_jerk);
    return motion;
  }
  const TorqueProfile torques = torques_on(chain, *options.load, q_start, way);
  diagnostics = torques.overloads("/goal");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const double stretch = torques.need(motion.law, kLawShareOfAcceleration).stretch;
  if (stretch > 1.0) motion.law = motion.law.stretched(stretch);
  motion.clock = common(clock_for(motion.law, by_acceleration, by_jerk), torques.clock(motion.law));
  motion.clock.stop = simplified(motion.clock.stop);
  return motion;
}

}  // namespace takt::motion
