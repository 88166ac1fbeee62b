#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <ruckig/ruckig.hpp>

#include "core/motion/leg.h"
#include "core/motion/motion_state.h"

/// The shortest stops that limits allow, by an independent generator (Ruckig).
namespace takt::test {

/// A stop from a velocity > 0 and an acceleration to rest: s, and how far it goes. NaN if the generator has no answer.
struct ShortestStop {
  double time, way;
};
inline ShortestStop shortest_stop(double velocity, double acceleration, double acceleration_max, double jerk_max) {
  ruckig::InputParameter<1> input;  // all members set: the generator leaves its own uninitialised
  input.control_interface = ruckig::ControlInterface::Velocity;
  input.current_position = input.target_position = input.target_velocity = input.target_acceleration = {0.0};
  input.current_velocity = {velocity};
  input.current_acceleration = {acceleration};
  input.max_velocity = {2.0 * velocity};
  input.max_acceleration = {acceleration_max};
  input.max_jerk = {jerk_max};
  ruckig::Ruckig<1> generator;
  ruckig::Trajectory<1> trajectory;
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  if (generator.calculate(input, trajectory) != ruckig::Result::Working) return {nothing, nothing};
  ShortestStop stop{.time = trajectory.get_duration(), .way = 0.0};
  double at_rest = 0.0, none = 0.0;
  trajectory.at_time(stop.time, stop.way, at_rest, none);
  return stop;
}

/// What no stop on the path can be below: s at which it ends, and its time (s). Each joint, and a frame on a line, needs
/// the way and the time that an axis with its limits needs that is alone.
struct LeastStop {
  double s, time;
};
/// @param from  path time of the motion, s   @param rate  of its clock, steady, in (0, 1]
inline LeastStop least_stop(const motion::ArmModel& arm, const motion::Motion& motion, double from, double rate) {
  const auto now = motion::joints_at(arm, motion, from);
  if (!now) return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const motion::LawPoint law = motion.law.at(from);
  LeastStop least{.s = law.s, .time = 0.0};
  kinematics::JointVector ways = kinematics::JointVector::Zero(now->q.size());
  for (Eigen::Index i = 0; i < ways.size(); ++i) {
    const double v = now->dq[i] * rate, a = now->ddq[i] * rate * rate, sign = v < 0.0 ? -1.0 : 1.0;
    if (std::abs(v) < 1e-6) continue;
    const ShortestStop stop = shortest_stop(std::abs(v), sign * a, arm.limits.acceleration[i], arm.limits.jerk[i]);
    ways[i] = stop.way;
    least.time = std::max(least.time, stop.time);
  }
  if (const auto* line = std::get_if<motion::CartesianLine>(&motion.path)) {
    const motion::CartesianLimits& c = arm.cartesian;
    for (const auto& [length, a, j] : {std::tuple(line->length, c.linear_acceleration, c.linear_jerk),
                                       std::tuple(line->angle, c.angular_acceleration, c.angular_jerk)}) {
      if (length < 1e-6) continue;
      const ShortestStop stop = shortest_stop(length * law.ds * rate, length * law.dds * rate * rate, a, j);
      least.s = std::max(least.s, law.s + stop.way / length);
      least.time = std::max(least.time, stop.time);
    }
  }
  const auto enough = [&](double tau) {
    const auto then = motion::joints_at(arm, motion, tau);
    return then && ((then->q - now->q).cwiseAbs().array() >= ways.array()).all();
  };
  constexpr double kStep = 5e-3;  // s
  double high = from;
  while (high < motion.duration() && !enough(high)) high += kStep;
  double low = std::max(from, high - kStep);
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (enough(middle) ? high : low) = middle;
  }
  least.s = std::max(least.s, motion.law.at(low).s);
  return least;
}

}  // namespace takt::test
