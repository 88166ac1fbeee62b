#include "core/activity/two_ways.h"

#include <algorithm>
#include <utility>

#include "core/command/device_sensors.h"

namespace takt::activity {
namespace {

using command::Cell;
using command::State;
using kinematics::JointVector;

/// A state as it was in the first cycle of the net.
State at_first(const State& state) {
  return State(command::apply(net::ValueType::kBoolean, "SnapshotBoolean",
                              {{"input", {.node = state.node()}}, {"trigger", {.node = {}, .constant = true}}}));
}

/// The set point stands at q.
State stands_at(const Cell& cell, const std::string& arm, const JointVector& q) {
  constexpr double kHere = 1e-6, kStanding = 1e-6;  // rad, rad/s: a motion in its blend is further away, and fast
  return near(command::commanded_joints(cell, arm), net::JointArray(q), kHere) &&
         is_less(largest(command::commanded_velocities(cell, arm)), kStanding);
}

/// Speed from outside, that of the program and that of the operator; and where the clock is, told to successors and
/// heard from the predecessor.
void connect(const Cell& cell, const std::string& arm, std::optional<double> tau, command::PlannedMotion& motion) {
  const auto has = [&cell](const std::string& channel) { return cell.channels.contains(channel); };
  const std::string time = path_time_channel(arm), rate = path_rate_channel(arm);
  if (has(speed_channel(arm))) motion.clock.speed = command::channel<net::Real>(cell, speed_channel(arm));
  if (!cell.override_channel.empty()) {
    const auto by_operator = min(max(command::channel<net::Real>(cell, cell.override_channel), 0.0), 1.0);
    motion.clock.speed = motion.clock.speed ? *motion.clock.speed * by_operator : by_operator;
  }
  if (!has(time) || !has(rate)) return;
  motion.tells = {.time = time, .rate = rate};
  if (tau)
    motion.begins = {.time = command::channel<net::Real>(cell, time) - *tau,
                     .rate = command::channel<net::Real>(cell, rate)};
}

/// @param duration  of the motion from rest: shares of time are its
motion::Blend blend_of(const BlendingCondition& wish, const motion::Motion& motion, double duration) {
  if (wish.distance) return {motion::Blend::Kind::kDistance, *wish.distance};
  const double left = (1.0 - *wish.time_share) * duration;
  const double share = 1.0 - motion.law.at(motion.duration() - left).s;
  return {motion::Blend::Kind::kFraction, std::clamp(share, 1e-3, 0.5)};
}

command::RuntimeCommand command_of(const TwoWays& ways, const std::string& name, const command::PlannedMotion& motion,
                                   const MotionParameters& wish) {
  command::Action action = command::planned(motion);
  if (wish.compliance) action = with_compliance(action, *wish.compliance);
  command::RuntimeCommand command(name, ways.actuator, action);
  if (wish.until) command.on_entered(*wish.until, cancel(command));
  return command;
}

Leavable leavable(const command::PlannedMotion& planned, const MotionParameters& wish, double duration) {
  return {.motion = planned.motion,
          .X_FM = planned.X_FM,
          .blend = blend_of(wish.blend, *planned.motion, duration),
          .partner = planned.partner ? planned.partner->motion : nullptr};
}

/// Where the arms are after it, and from what they may be taken over.
void add_forecasts(const TwoWays& ways, const MotionParameters& wish, Prepared& prepared) {
  for (const auto& [arm, begin] : ways.begins) {
    const bool leads = arm == ways.clock;
    const motion::Motion& motion = leads ? *ways.from_rest.motion : *ways.from_rest.partner->motion;
    Forecast& forecast = prepared.forecasts[arm];
    if (!wish.until) forecast.after = ActuatorState::at_rest(motion.q_goal);
    prepared.begins[arm].push_back(begin.rest);
  }
}

void add_last(const command::SubjectPtr& command, const Leavable& motion, Prepared& prepared) {
  for (auto& [arm, forecast] : prepared.forecasts) forecast.last.push_back({command, motion});
}

}  // namespace

device::Seam seam_of(const motion::JointSample& state) {
  device::Seam seam;
  seam.q = state.q;
  seam.dq = state.dq;
  seam.ddq = state.ddq;
  return seam;
}

device::Seam seam_at_rest(const JointVector& q) {
  return seam_of({q, JointVector::Zero(q.size()), JointVector::Zero(q.size())});
}

device::Seam seam_in_motion(const Precedent::Leaving& leaving, const motion::JointSample& begin) {
  return leaving.exact ? seam_of(begin) : device::Seam{};
}

Prepared prepare_two_ways(const Situation& situation, TwoWays ways, const MotionParameters& wish) {
  const Cell& cell = situation.cell;
  const double duration = ways.from_rest.motion->duration();
  const bool leavable_later = wish.blend.wanted() && duration > 0.0;
  Prepared prepared;
  connect(cell, ways.clock, std::nullopt, ways.from_rest);
  add_forecasts(ways, wish, prepared);
  const auto rest = command_of(ways, ways.from_blend ? "from rest" : ways.name, ways.from_rest, wish);
  if (leavable_later) add_last(rest.subject(), leavable(ways.from_rest, wish, duration), prepared);
  prepared.command = rest;
  prepared.at_share = [action = rest.action()](double share) { return action.at_path(share); };
  if (!ways.from_blend) return prepared;

  connect(cell, ways.clock, ways.tau, *ways.from_blend);
  const auto going_on = command_of(ways, "from a blend", *ways.from_blend, wish);
  if (leavable_later) add_last(going_on.subject(), leavable(*ways.from_blend, wish, duration), prepared);
  for (const auto& [arm, begin] : ways.begins) {
    if (begin.blend) prepared.begins[arm].push_back(*begin.blend);
    prepared.taken_over.insert(arm);
  }
  const State rests = at_first(stands_at(cell, ways.clock, ways.from_rest.motion->q_start));
  command::TransactionCommand both(ways.name);
  both.add(going_on).add(rest);
  both.on_entered(rests, start(rest));
  both.on_entered(!rests, start(going_on));
  prepared.command = both;
  prepared.at_share = [one = rest.action(), other = going_on.action()](double share) {
    return one.at_path(share) || other.at_path(share);
  };
  return prepared;
}

}  // namespace takt::activity
