#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/kinematics/joint_range.h"
#include "core/motion/clock_bounds.h"
#include "core/motion/leg.h"
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

/// Where a base that cannot go sideways points while it drives to a place that lies `way` from it: there or straight
/// away from it, whichever needs the least turns before and after. rad, as a position of its joint yaw.
double heading_for(const Eigen::Vector2d& way, double yaw_start, double yaw_goal) {
  constexpr double kHalfTurn = std::numbers::pi;
  const double ahead = std::atan2(way.y(), way.x());
  const auto turns = [&](double heading) { return std::abs(heading - yaw_start) + std::abs(yaw_goal - heading); };
  double best = ahead;
  const double first = std::floor((std::min(yaw_start, yaw_goal) - ahead) / kHalfTurn);
  const double last = std::ceil((std::max(yaw_start, yaw_goal) - ahead) / kHalfTurn);
  for (double k = first; k <= last; ++k) {
    const double heading = ahead + k * kHalfTurn;
    if (turns(heading) < turns(best) - 1e-9) best = heading;
  }
  return best;
}

/// Where such a base turns, drives to and turns again; the last is the goal. Parts without a way are left out.
std::vector<JointVector> stations(const JointVector& q_start, const JointVector& q_goal) {
  constexpr double kNoWay = 1e-9;  // m, rad
  const Eigen::Vector2d way = (q_goal - q_start).head<2>();
  std::vector<JointVector> stations{q_start};
  if (way.norm() > kNoWay) {
    const double heading = heading_for(way, q_start[2], q_goal[2]);
    for (const JointVector& place : {q_start, q_goal}) {
      stations.push_back(place);
      stations.back()[2] = heading;
    }
  }
  stations.push_back(q_goal);
  const auto same = [](const JointVector& a, const JointVector& b) { return (a - b).cwiseAbs().maxCoeff() <= kNoWay; };
  stations.erase(std::unique(stations.begin(), stations.end(), same), stations.end());
  stations.erase(stations.begin());
  if (!stations.empty()) stations.back() = q_goal;
  return stations;
}

/// One path with a rest at each station.
Result<Motion> plan_rolling(const kinematics::Chain& chain, const JointLimits& limits, const JointVector& q_start,
                            const JointVector& q_goal, const MotionOptions& options) {
  const CartesianLimits no_frame_moves;
  const ArmModel base{.chain = chain,
                      .inverse = nullptr,
                      .limits = limits,
                      .cartesian = no_frame_moves,
                      .X_FM = options.X_FM,
                      .load = options.load};
  std::vector<LegMaker> makers;
  for (const JointVector& station : stations(q_start, q_goal)) {
    makers.push_back([&, station](const JointVector& q) {
      auto leg = ptp_leg(base, q, station);
      if (leg) {
        leg->velocity = options.velocity;
        leg->acceleration = options.acceleration;
      }
      return leg;
    });
  }
  auto plan = plan_sequence(base, q_start, makers);
  if (!plan) return std::unexpected(std::move(plan.error()));
  return std::move(plan->motion);
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
  const JointVector inside = kinematics::into_range(q_goal, limits.lower, limits.upper);
  if (inside != q_goal) return plan_ptp(chain, limits, q_start, inside, options);

  Motion motion{.path = JointLine{.q_start = q_start, .q_goal = q_goal},
                .law = {},
                .clock = {},
                .q_start = q_start,
                .q_goal = q_goal,
                .shares = {{.velocity = options.velocity, .acceleration = options.acceleration}}};
  const JointVector way = q_goal - q_start;
  constexpr double kNoWay = 1e-12;  // rad or m: less is only the rounding of the inputs
  if (way.cwiseAbs().maxCoeff() < kNoWay) return motion;
  if (limits.nonholonomic) return plan_rolling(chain, limits, q_start, q_goal, options);
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
