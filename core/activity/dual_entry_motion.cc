#include "core/activity/dual_entry_motion.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "core/expression/device_sensors.h"
#include "core/motion/motion_state.h"

namespace takt::activity {
namespace {

using expression::Cell;
using expression::State;
using kinematics::JointVector;

/// A state as it was in the first cycle of the net.
State at_first(const State& state) {
  return State(expression::apply(net::ValueType::kBoolean, "SnapshotBoolean",
                                 {{"input", {.node = state.node()}}, {"trigger", {.node = {}, .constant = true}}}));
}

/// The set point rests at q.
State stands_at(const Cell& cell, const std::string& arm, const JointVector& q) {
  constexpr double kHere = 1e-6, kStanding = 1e-6;  // rad, rad/s: a motion in its blend is further away, and fast
  return near(expression::commanded_joints(cell, arm), net::JointArray(q), kHere) &&
         is_less(largest(expression::commanded_velocities(cell, arm)), kStanding);
}

/// Where the clock is, shown to successors and read from the predecessor.
void connect(const Cell& cell, const std::string& arm, std::optional<double> tau, command::PlannedMotion& motion) {
  const auto has = [&cell](const std::string& channel) { return cell.channels.contains(channel); };
  const std::string time = path_time_channel(arm), rate = path_rate_channel(arm);
  if (!has(time) || !has(rate)) return;
  motion.clock_outputs = {.time = time, .rate = rate};
  if (tau)
    motion.clock_initial = {.time = expression::channel<net::Real>(cell, time) - *tau,
                            .rate = expression::channel<net::Real>(cell, rate)};
}

/// @param duration  of the motion from rest: shares of time are its
motion::Blend blend_of(const BlendingCondition& blending, const motion::Motion& motion, double duration) {
  if (!blending.time_share) return blending.along_path;
  const double left = (1.0 - *blending.time_share) * duration;
  const double share = 1.0 - motion.law.at(motion.duration() - left).s;
  return {motion::Blend::Kind::kFraction, std::clamp(share, 1e-3, 0.5)};
}

/// One of the two entries: under which names it shows how it ended, and how many motions of its
/// predecessor it does first.
struct Entry {
  const char *touch, *force, *at_goal, *no_force, *lost, *off_force, *suffix;
  int before = 0;

  [[nodiscard]] std::string broken(int motion) const { return fmt::format("unless {}{}", motion, suffix); }
  [[nodiscard]] std::string silent(int motion) const { return fmt::format("unless {} silent{}", motion, suffix); }
};
constexpr Entry kFromRest{"touch", "force", "at goal", "no force", "lost", "off force", ""};
constexpr Entry kFromBlend{
    "touch after a blend", "force after a blend",     "at goal after a blend", "no force after a blend",
    "lost after a blend",  "off force after a blend", " after a blend",        1};

/// What must not hold stops it, each while its motion is being done.
/// @param abort_if  of each motion, those of the predecessor, with numbers below 0, first
void add_abort(const std::vector<std::optional<State>>& abort_if, const command::PlannedMotion& motion,
               const Entry& entry, command::RuntimeCommand& command) {
  const command::Action action = command.action();
  for (int i = 0; i < static_cast<int>(abort_if.size()); ++i) {
    const auto& one = abort_if[static_cast<std::size_t>(i)];
    if (!one) continue;
    State holds = *one;
    if (i > 0) holds = holds && action.via_passed(i - 1);
    if (i < static_cast<int>(motion.handed_over.size())) holds = holds && !action.via_passed(i);
    command.on_entered(holds, cancel(command));
    command.fails_if(not_allowed(holds, command));
    command.capture(entry.broken(i - entry.before), action.progress(), holds);
    capture_compared(command, holds, entry.broken(i - entry.before));
    command.capture(entry.silent(i - entry.before), action.progress(),
                    is_null(expression::BooleanSensor(holds.node())));
  }
}

/// That of the motion before on what is left of it, then those of its own.
std::vector<std::optional<State>> with_before(const PlanningContext& planning, const DualEntryMotion& dual) {
  std::vector<std::optional<State>> all{planning.predecessors.find(dual.clock)->second.leaving->motion.abort_if};
  all.insert(all.end(), dual.abort_if.begin(), dual.abort_if.end());
  return all;
}

/// @param before  how many motions of the predecessor come first
command::Action offset_over(const command::Action& motion, const OffsetPlan& offset, int before) {
  return command::force_offset(motion, offset.pressing, offset.parameters,
                               offset.first + static_cast<std::size_t>(before));
}

/// The first wrench in a formula; null: none.
expression::ExpressionPtr wrench_in(const expression::ExpressionPtr& formula) {
  if (formula == nullptr || formula->type == net::ValueType::kWrench) return formula;
  for (const auto& [port, input] : formula->inputs)
    if (auto found = wrench_in(input)) return found;
  return nullptr;
}

/// A condition counts from where its motion begins: others may be blended into it.
command::RuntimeCommand command_of(const Cell& cell, const DualEntryMotion& dual, const std::string& name,
                                   const command::PlannedMotion& motion, const MotionOptions& options,
                                   const std::optional<command::WeavePlan>& weaves, const Entry& entry) {
  command::Action action = command::planned(motion);
  if (weaves) action = command::woven(action, *weaves);
  if (dual.offset) action = offset_over(action, *dual.offset, entry.before);
  if (options.compliance) action = with_compliance(action, *options.compliance);
  command::RuntimeCommand command(name, dual.actuator, action);
  if (dual.offset) {
    const State silent = action.state("no_force");
    command.on_entered(silent, cancel(command));
    command.fails_if(silent.once());
    command.capture(entry.no_force, expression::tool_pose(cell, dual.clock), silent);
    const auto leaves = [&](const char* state, const char* key) {
      const State left = action.state(state);
      command.on_entered(left, cancel(command));
      command.fails_if(left.once());
      command.capture(key, action.progress(), left);
    };
    leaves("lost_contact", entry.lost);
    if (dual.offset->parameters.off_max) leaves("off_force", entry.off_force);
  }
  if (!options.until) return command;
  State until = *options.until;
  if (!motion.handed_over.empty()) until = until && action.via_passed(static_cast<int>(motion.handed_over.size()) - 1);
  command.on_entered(until, cancel(command));
  command.fails_if(not_touched(until, options.must_touch, command));
  // A sensor that is silent stops the arm, but it has not felt anything.
  command.capture(entry.touch, expression::tool_pose(cell, dual.clock), until);
  if (const auto wrench = wrench_in(options.until->node()); wrench != nullptr)
    command.capture(entry.force, force(expression::WrenchSensor(wrench)), until);
  // Kept: where the motion is a part, its net runs on after it, and an action that has ended shows null.
  constexpr double kRounding = 1e-9;
  command.capture(entry.at_goal, action.progress(), is_greater(action.progress(), 1.0 - kRounding));
  return command;
}

BlendSource blend_source(const DualEntryMotion& dual, const command::PlannedMotion& planned,
                         const MotionOptions& options, double duration) {
  return {.motion = planned.motion,
          .X_FM = planned.X_FM,
          .blend = blend_of(options.blend, *planned.motion, duration),
          .partner = planned.partner ? planned.partner->motion : nullptr,
          .partner_X_FM = planned.partner ? planned.partner->X_FM : Eigen::Isometry3d::Identity(),
          .arm = dual.clock,
          .abort_if = dual.abort_if.empty() ? std::nullopt : dual.abort_if.back(),
          .compliance = options.compliance};
}

/// Where the arms are after it, and from what they may be taken over.
void add_end_states(const DualEntryMotion& dual, const MotionOptions& options, PlannedActivity& prepared) {
  for (const auto& [arm, begin] : dual.begins) {
    const bool leads = arm == dual.clock;
    const motion::Motion& motion = leads ? *dual.from_rest.motion : *dual.from_rest.partner->motion;
    EndState& end_state = prepared.end_states[arm];
    if (!options.until && !dual.offset) end_state.after = ActuatorState::at_rest(motion.q_goal);
    prepared.begins[arm].push_back(begin.rest);
  }
}

/// What goes on with a motion does the rest of that one too, with its own springs.
bool same_compliance(const PlanningContext& planning, const std::string& arm, const MotionOptions& options) {
  const auto before = planning.predecessors.find(arm);
  if (before == planning.predecessors.end() || !before->second.leaving) return true;
  return command::same(before->second.leaving->motion.compliance, options.compliance);
}

/// Where a weave is the first or the last thing the motion is not joined or left in motion.
Diagnostics add_weaves(const Cell& cell, const ArmPlans& plans, DualEntryMotion& dual, MotionOptions& options) {
  const auto woven = [](const auto& weave) { return weave.has_value(); };
  if (std::ranges::none_of(plans.weaves, woven)) return {};
  const expression::MountedArm& arm = cell.arms.find(plans.arm)->second;
  const auto plan = [&](const command::PlannedMotion& motion, const command::Weaves& weaves) {
    return command::plan_weaves(
        arm, {.motion = motion.motion.get(), .X_FM = motion.X_FM, .handed_over = motion.handed_over}, weaves);
  };
  auto from_rest = plan(dual.from_rest, plans.weaves);
  if (!from_rest) return std::move(from_rest.error());
  dual.weaves_from_rest = std::move(*from_rest);
  if (plans.weaves.back()) options.blend = {};
  if (plans.weaves.front()) dual.from_blend.reset();
  if (!dual.from_blend) return {};
  command::Weaves with_before{std::nullopt};
  with_before.insert(with_before.end(), plans.weaves.begin(), plans.weaves.end());
  if (auto from_blend = plan(*dual.from_blend, with_before)) {
    dual.weaves_from_blend = std::move(*from_blend);
  } else {
    dual.from_blend.reset();  // it waits for the natural end of the one before
  }
  return {};
}

/// The same for a force offset.
Diagnostics add_offset(const ArmPlans& plans, DualEntryMotion& dual, MotionOptions& options) {
  if (!plans.offset) return {};
  dual.offset = plans.offset;
  const auto check = [&](const command::PlannedMotion& motion, const Entry& entry) {
    Diagnostics placed;
    const auto action = offset_over(command::planned(motion), *plans.offset, entry.before);
    placed.append(action.model().check(dual.actuator.model()), pointer_segment(plans.offset->first));
    return placed;
  };
  if (Diagnostics wrong = check(dual.from_rest, kFromRest); wrong.has_errors()) return wrong;
  options.blend = {};
  if (plans.offset->first == 0 || (dual.from_blend && check(*dual.from_blend, kFromBlend).has_errors()))
    dual.from_blend.reset();
  return {};
}

GuardedOutcome outcome_of(const RunView& run, const GuardedEnd& end) {
  using enum GuardedOutcome::Kind;
  bool at_goal = false;
  for (const Entry& entry : {kFromRest, kFromBlend}) {
    at_goal = at_goal || run.value<net::Real>(entry.at_goal).has_value();
    const auto touch = run.value<net::Frame>(entry.touch);
    if (!touch) continue;
    GuardedOutcome outcome{.kind = kTouched, .X_BT = touch};
    if (const auto felt = run.value<net::Vector>(entry.force)) outcome.force = *felt;
    return outcome;
  }
  if (at_goal) return {.kind = kNotTouched};
  return {.kind = run.may_have_failed() && !end.broken && !end.no_force && !end.lost && !end.off_force ? kSensorSilent
                                                                                                       : kInterrupted};
}

void add_last(const expression::SubjectPtr& command, const BlendSource& motion, PlannedActivity& prepared) {
  for (auto& [arm, end_state] : prepared.end_states) end_state.last.push_back({command, motion});
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

device::Seam seam_in_motion(const Predecessor::BlendOut& leaving, const motion::JointSample& begin) {
  return leaving.exact ? seam_of(begin) : device::Seam{};
}

PlannedActivity prepare_dual_entry(const PlanningContext& planning, DualEntryMotion dual,
                                   const MotionOptions& options) {
  const Cell& cell = planning.cell;
  const double duration = dual.from_rest.motion->duration();
  const bool can_blend_out = options.blend.wanted() && duration > 0.0;
  PlannedActivity prepared;
  connect(cell, dual.clock, std::nullopt, dual.from_rest);
  add_end_states(dual, options, prepared);
  if (options.until || dual.offset || options.compliance)
    for (const auto& [arm, begin] : dual.begins) prepared.touching.insert(arm);
  // Without channels the clock of its predecessor is unknown; another compliance would come too soon.
  if (!cell.channels.contains(path_time_channel(dual.clock)) || !same_compliance(planning, dual.clock, options))
    dual.from_blend.reset();
  auto rest = command_of(cell, dual, dual.from_blend ? "from rest" : dual.name, dual.from_rest, options,
                         dual.weaves_from_rest, kFromRest);
  add_abort(dual.abort_if, dual.from_rest, kFromRest, rest);
  prepared.motions.push_back({rest.subject(), dual.from_rest.handed_over, 0.0});
  if (can_blend_out) add_last(rest.subject(), blend_source(dual, dual.from_rest, options, duration), prepared);
  prepared.command = rest;
  prepared.at_share = [action = rest.action()](double share) { return action.at_path(share); };
  if (!dual.from_blend) return prepared;

  connect(cell, dual.clock, dual.tau, *dual.from_blend);
  auto going_on = command_of(cell, dual, "from a blend", *dual.from_blend, options, dual.weaves_from_blend, kFromBlend);
  add_abort(with_before(planning, dual), *dual.from_blend, kFromBlend, going_on);
  std::vector<double> handed_over = dual.from_blend->handed_over;
  const double own_begin = handed_over.empty() ? 0.0 : handed_over.front();
  if (!handed_over.empty()) handed_over.erase(handed_over.begin());
  prepared.motions.push_back({going_on.subject(), std::move(handed_over), own_begin});
  if (can_blend_out) add_last(going_on.subject(), blend_source(dual, *dual.from_blend, options, duration), prepared);
  for (const auto& [arm, begin] : dual.begins) {
    if (begin.blend) prepared.begins[arm].push_back(*begin.blend);
    prepared.taken_over[arm] = {going_on.subject(), own_begin};
  }
  const State rests = at_first(stands_at(cell, dual.clock, dual.from_rest.motion->q_start));
  command::TransactionCommand both(dual.name);
  both.add(going_on).add(rest);
  both.on_entered(rests, start(rest));
  both.on_entered(!rests, start(going_on));
  prepared.command = both;
  prepared.at_share = [one = rest.action(), other = going_on.action()](double share) {
    return one.at_path(share) || other.at_path(share);
  };
  return prepared;
}

Result<PlannedActivity> prepare_dual_entry(const PlanningContext& planning, ArmPlans plans,
                                           const MotionOptions& options) {
  const auto planned = [&](motion::SequencePlan plan) {
    return command::PlannedMotion{.motion = std::make_shared<const motion::Motion>(std::move(plan.motion)),
                                  .X_FM = plans.model.X_FM,
                                  .handed_over = std::move(plan.handed_over),
                                  .clock = {},
                                  .name = plans.name};
  };
  DualEntryMotion dual{.name = plans.name,
                       .actuator = command::arm(planning.cell, plans.arm),
                       .clock = plans.arm,
                       .from_rest = planned(std::move(plans.from_rest)),
                       .abort_if = std::move(plans.abort_if)};
  dual.begins[plans.arm].rest = seam_at_rest(dual.from_rest.motion->q_start);
  const auto begin = plans.from_blend ? motion::joints_at(plans.model, plans.from_blend->motion, 0.0) : std::nullopt;
  if (begin) {
    dual.from_blend = planned(std::move(*plans.from_blend));
    const Predecessor::BlendOut& leaving = *planning.predecessors.find(plans.arm)->second.leaving;
    dual.tau = leaving.tau;
    dual.begins[plans.arm].blend = seam_in_motion(leaving, *begin);
  }
  MotionOptions own = options;
  Diagnostics wrong = add_weaves(planning.cell, plans, dual, own);
  wrong.append(add_offset(plans, dual, own));
  if (wrong.has_errors()) return std::unexpected(std::move(wrong));
  return prepare_dual_entry(planning, std::move(dual), own);
}

std::optional<motion::Departure> departure_of(const Predecessor& before, const Eigen::Isometry3d& X_FM) {
  constexpr double kSame = 1e-12;
  if (!before.leaving || !before.leaving->motion.X_FM.isApprox(X_FM, kSame)) return std::nullopt;
  const Predecessor::BlendOut& leaving = *before.leaving;
  return motion::Departure{
      .motion = *leaving.motion.motion, .tau = leaving.tau, .lead = leaving.lead, .blend = leaving.motion.blend};
}

std::string_view name_of(GuardedOutcome::Kind kind) {
  static constexpr std::array<std::string_view, 4> kNames = {"touched", "not touched", "sensor silent", "interrupted"};
  return kNames.at(static_cast<std::size_t>(kind));
}

GuardedOutcome guarded_outcome(const RunView& run) {
  constexpr int kMost = 100;  // motions in one
  (void)run.failure();        // who asks for the outcome knows of it
  return guarded_end(run.narrowed_to(kFromRest.at_goal), kMost).outcome;
}

GuardedEnd guarded_end(const RunView& run, int motions) {
  GuardedEnd end;
  for (const Entry& entry : {kFromRest, kFromBlend}) {
    end.no_force = end.no_force || run.value<net::Frame>(entry.no_force).has_value();
    if (const auto at = run.value<net::Real>(entry.lost)) end.lost = *at;
    if (const auto at = run.value<net::Real>(entry.off_force)) end.off_force = *at;
    for (int i = -1; i < motions; ++i) {
      if (run.value<net::Real>(entry.silent(i))) end.broken = {.motion = i, .silent = true};
      if (run.value<net::Real>(entry.broken(i)))
        end.broken = {.motion = i, .silent = false, .compared = compared_text(run, entry.broken(i))};
    }
  }
  end.outcome = outcome_of(run, end);
  return end;
}

}  // namespace takt::activity
