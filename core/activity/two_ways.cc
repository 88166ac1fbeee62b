#include "core/activity/two_ways.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/expression/device_sensors.h"
#include "core/motion/motion_state.h"

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
  if (!wish.time_share) return wish.way;
  const double left = (1.0 - *wish.time_share) * duration;
  const double share = 1.0 - motion.law.at(motion.duration() - left).s;
  return {motion::Blend::Kind::kFraction, std::clamp(share, 1e-3, 0.5)};
}

/// One of the two ways: under which names it shows how it ended, and how many motions of somebody else it does first.
struct Way {
  const char *touch, *progress, *no_force, *way;
  int before = 0;

  [[nodiscard]] std::string broken(int motion) const { return fmt::format("unless {}{}", motion, way); }
  [[nodiscard]] std::string silent(int motion) const { return fmt::format("unless {} silent{}", motion, way); }
};
constexpr Way kFromRest{"touch", "progress", "no force", ""};
constexpr Way kFromBlend{"touch after a blend", "progress after a blend", "no force after a blend", " after a blend",
                         1};

/// What must not hold stops it, each while its motion is being done.
/// @param unless  of each motion, those of somebody else, with numbers below 0, first
void add_unless(const std::vector<std::optional<State>>& unless, const command::PlannedMotion& motion, const Way& way,
                command::RuntimeCommand& command) {
  const command::Action action = command.action();
  for (int i = 0; i < static_cast<int>(unless.size()); ++i) {
    const auto& one = unless[static_cast<std::size_t>(i)];
    if (!one) continue;
    State holds = *one;
    if (i > 0) holds = holds && action.via_passed(i - 1);
    if (i < static_cast<int>(motion.handed_over.size())) holds = holds && !action.via_passed(i);
    command.on_entered(holds, cancel(command));
    command.capture(way.broken(i - way.before), action.progress(), holds);
    command.capture(way.silent(i - way.before), action.progress(), is_null(command::BooleanSensor(holds.node())));
  }
}

/// That of the motion before on what is left of it, then those of its own.
std::vector<std::optional<State>> with_before(const Situation& situation, const TwoWays& ways) {
  std::vector<std::optional<State>> all{situation.precedents.find(ways.clock)->second.leaving->motion.unless};
  all.insert(all.end(), ways.unless.begin(), ways.unless.end());
  return all;
}

/// @param before  how many motions of somebody else come first
command::Action offset_over(const command::Action& motion, const OffsetPlan& offset, int before) {
  return command::force_offset(motion, offset.pressing, offset.wish, offset.first + static_cast<std::size_t>(before));
}

/// A condition counts from where the motion that it stands at begins: others may be blended into it.
command::RuntimeCommand command_of(const Cell& cell, const TwoWays& ways, const std::string& name,
                                   const command::PlannedMotion& motion, const MotionParameters& wish,
                                   const std::optional<command::WeavePlan>& weaves, const Way& way) {
  command::Action action = command::planned(motion);
  if (weaves) action = command::woven(action, *weaves);
  if (ways.offset) action = offset_over(action, *ways.offset, way.before);
  if (wish.compliance) action = with_compliance(action, *wish.compliance);
  command::RuntimeCommand command(name, ways.actuator, action);
  if (ways.offset) {
    const State silent = action.state("no_force");
    command.on_entered(silent, cancel(command));
    command.capture(way.no_force, command::tool_pose(cell, ways.clock), silent);
  }
  if (!wish.until) return command;
  State until = *wish.until;
  if (!motion.handed_over.empty()) until = until && action.via_passed(static_cast<int>(motion.handed_over.size()) - 1);
  command.on_entered(until, cancel(command));
  if (!ways.tells_end) return command;
  // A sensor that is silent stops the arm, but it has not felt anything.
  command.capture(way.touch, command::tool_pose(cell, ways.clock), until);
  command.observe(way.progress, action.progress());
  return command;
}

Leavable leavable(const TwoWays& ways, const command::PlannedMotion& planned, const MotionParameters& wish,
                  double duration) {
  return {.motion = planned.motion,
          .X_FM = planned.X_FM,
          .blend = blend_of(wish.blend, *planned.motion, duration),
          .partner = planned.partner ? planned.partner->motion : nullptr,
          .partner_X_FM = planned.partner ? planned.partner->X_FM : Eigen::Isometry3d::Identity(),
          .arm = ways.clock,
          .unless = ways.unless.empty() ? std::nullopt : ways.unless.back(),
          .compliance = wish.compliance};
}

/// Where the arms are after it, and from what they may be taken over.
void add_forecasts(const TwoWays& ways, const MotionParameters& wish, Prepared& prepared) {
  for (const auto& [arm, begin] : ways.begins) {
    const bool leads = arm == ways.clock;
    const motion::Motion& motion = leads ? *ways.from_rest.motion : *ways.from_rest.partner->motion;
    Forecast& forecast = prepared.forecasts[arm];
    if (!wish.until && !ways.offset) forecast.after = ActuatorState::at_rest(motion.q_goal);
    prepared.begins[arm].push_back(begin.rest);
  }
}

/// What goes on with a motion does the rest of that one too, with its own springs.
bool gives_way_as_before(const Situation& situation, const std::string& arm, const MotionParameters& wish) {
  const auto before = situation.precedents.find(arm);
  if (before == situation.precedents.end() || !before->second.leaving) return true;
  return command::same(before->second.leaving->motion.compliance, wish.compliance);
}

/// Where a weave is the first or the last thing the motion is not joined or left on the way.
Findings add_weaves(const Cell& cell, const ArmPlans& plans, TwoWays& ways, MotionParameters& wish) {
  const auto woven = [](const auto& weave) { return weave.has_value(); };
  if (std::ranges::none_of(plans.weaves, woven)) return {};
  const command::MountedArm& arm = cell.arms.find(plans.arm)->second;
  const auto plan = [&](const command::PlannedMotion& motion, const command::WeaveWishes& wishes) {
    return command::plan_weaves(
        arm, {.motion = motion.motion.get(), .X_FM = motion.X_FM, .handed_over = motion.handed_over}, wishes);
  };
  auto from_rest = plan(ways.from_rest, plans.weaves);
  if (!from_rest) return std::move(from_rest.error());
  ways.weaves_from_rest = std::move(*from_rest);
  if (plans.weaves.back()) wish.blend = {};
  if (plans.weaves.front()) ways.from_blend.reset();
  if (!ways.from_blend) return {};
  command::WeaveWishes with_before{std::nullopt};
  with_before.insert(with_before.end(), plans.weaves.begin(), plans.weaves.end());
  if (auto from_blend = plan(*ways.from_blend, with_before)) {
    ways.weaves_from_blend = std::move(*from_blend);
  } else {
    ways.from_blend.reset();  // it waits for the natural end of the one before
  }
  return {};
}

/// The same for a force offset.
Findings add_offset(const ArmPlans& plans, TwoWays& ways, MotionParameters& wish) {
  if (!plans.offset) return {};
  ways.offset = plans.offset;
  const auto check = [&](const command::PlannedMotion& motion, const Way& way) {
    Findings placed;
    const auto action = offset_over(command::planned(motion), *plans.offset, way.before);
    placed.append(action.model().check(ways.actuator.model()), pointer_segment(plans.offset->first));
    return placed;
  };
  if (Findings wrong = check(ways.from_rest, kFromRest); wrong.has_errors()) return wrong;
  wish.blend = {};
  if (plans.offset->first == 0 || (ways.from_blend && check(*ways.from_blend, kFromBlend).has_errors()))
    ways.from_blend.reset();
  return {};
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
  // Without channels nobody could tell it where the clock of the one before is; other springs would come too soon.
  if (!cell.channels.contains(path_time_channel(ways.clock)) || !gives_way_as_before(situation, ways.clock, wish))
    ways.from_blend.reset();
  auto rest = command_of(cell, ways, ways.from_blend ? "from rest" : ways.name, ways.from_rest, wish,
                         ways.weaves_from_rest, kFromRest);
  add_unless(ways.unless, ways.from_rest, kFromRest, rest);
  prepared.motions.push_back({rest.subject(), ways.from_rest.handed_over, 0.0});
  if (leavable_later) add_last(rest.subject(), leavable(ways, ways.from_rest, wish, duration), prepared);
  prepared.command = rest;
  prepared.at_share = [action = rest.action()](double share) { return action.at_path(share); };
  if (!ways.from_blend) return prepared;

  connect(cell, ways.clock, ways.tau, *ways.from_blend);
  auto going_on = command_of(cell, ways, "from a blend", *ways.from_blend, wish, ways.weaves_from_blend, kFromBlend);
  add_unless(with_before(situation, ways), *ways.from_blend, kFromBlend, going_on);
  std::vector<double> handed_over = ways.from_blend->handed_over;
  const double own_begin = handed_over.empty() ? 0.0 : handed_over.front();
  if (!handed_over.empty()) handed_over.erase(handed_over.begin());
  prepared.motions.push_back({going_on.subject(), std::move(handed_over), own_begin});
  if (leavable_later) add_last(going_on.subject(), leavable(ways, *ways.from_blend, wish, duration), prepared);
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

Result<Prepared> prepare_two_ways(const Situation& situation, ArmPlans plans, const MotionParameters& wish) {
  const auto planned = [&](motion::SequencePlan plan) {
    return command::PlannedMotion{.motion = std::make_shared<const motion::Motion>(std::move(plan.motion)),
                                  .X_FM = plans.model.X_FM,
                                  .handed_over = std::move(plan.handed_over),
                                  .clock = {},
                                  .name = plans.name};
  };
  TwoWays ways{.name = plans.name,
               .actuator = command::arm(situation.cell, plans.arm),
               .clock = plans.arm,
               .from_rest = planned(std::move(plans.from_rest)),
               .tells_end = plans.tells_end,
               .unless = std::move(plans.unless)};
  ways.begins[plans.arm].rest = seam_at_rest(ways.from_rest.motion->q_start);
  const auto begin = plans.from_blend ? motion::joints_at(plans.model, plans.from_blend->motion, 0.0) : std::nullopt;
  if (begin) {
    ways.from_blend = planned(std::move(*plans.from_blend));
    const Precedent::Leaving& leaving = *situation.precedents.find(plans.arm)->second.leaving;
    ways.tau = leaving.tau;
    ways.begins[plans.arm].blend = seam_in_motion(leaving, *begin);
  }
  MotionParameters own = wish;
  Findings wrong = add_weaves(situation.cell, plans, ways, own);
  wrong.append(add_offset(plans, ways, own));
  if (wrong.has_errors()) return std::unexpected(std::move(wrong));
  return prepare_two_ways(situation, std::move(ways), own);
}

std::optional<motion::Departure> departure_of(const Precedent& before, const Eigen::Isometry3d& X_FM) {
  constexpr double kSame = 1e-12;
  if (!before.leaving || !before.leaving->motion.X_FM.isApprox(X_FM, kSame)) return std::nullopt;
  const Precedent::Leaving& leaving = *before.leaving;
  return motion::Departure{
      .motion = *leaving.motion.motion, .tau = leaving.tau, .lead = leaving.lead, .blend = leaving.motion.blend};
}

GuardedEnd guarded_end(const ActivityRun& run, int motions) {
  constexpr double kRounding = 1e-9;
  GuardedEnd end;
  for (const Way& way : {kFromRest, kFromBlend}) {
    if (const auto touch = run.value<net::Frame>(way.touch)) end.touch = touch;
    end.no_force = end.no_force || run.value<net::Frame>(way.no_force).has_value();
    end.at_goal = end.at_goal || run.value<net::Real>(way.progress).value_or(0.0) > 1.0 - kRounding;
    for (int i = -1; i < motions; ++i) {
      if (run.value<net::Real>(way.silent(i))) end.broken = {.motion = i, .silent = true};
      if (run.value<net::Real>(way.broken(i))) end.broken = {.motion = i, .silent = false};
    }
  }
  return end;
}

}  // namespace takt::activity
