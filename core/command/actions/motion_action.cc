#include "core/command/actions/motion_action.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/planned_path.h"
#include "core/command/command_tree.h"
#include "core/device/description.h"
#include "core/expression/device_sensors.h"
#include "core/motion/path_clock.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

device::Seam rest_at(const JointVector& q) {
  const JointVector zero = JointVector::Zero(q.size());
  return {.q = q, .dq = zero, .ddq = zero};
}

/// Path clock, time law, path: a request to cancel and a pause are target rates of the clock.
class PlannedModel final : public ActionModel {
 public:
  explicit PlannedModel(PlannedMotion motion) : motion_(std::move(motion)) {}

  [[nodiscard]] std::string_view name() const override { return motion_.name; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override {
    return motion_.partner ? SetPointKind::kPair : kind_of(motion_.motion->path);
  }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas = motion_.clock.formulas();
    for (const auto* begin : {&motion_.clock_initial.time, &motion_.clock_initial.rate})
      if (*begin) formulas.push_back((*begin)->node());
    if (motion_.begins_there) formulas.push_back(motion_.begins_there->node());
    return formulas;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    const motion::Motion& motion = *motion_.motion;
    add_clock(fragment, actuator, motion, motion_.clock);
    add_hand_over(fragment);
    if (motion_.begins_there) add_start_check(fragment);
    SetPoint set_point = add_path(fragment, "path", motion.path, motion_.X_FM);
    if (motion_.partner) {
      const PlannedPartner& partner = *motion_.partner;
      SetPoint pair{.kind = SetPointKind::kPair, .ports = {}, .constants = {}};
      pair.parts = {std::move(set_point), add_path(fragment, "path_2", partner.motion->path, partner.X_FM)};
      set_point = std::move(pair);
    }
    const std::string stopped = fragment.gate_with_cancel("stopped", "And", "clock.standstill");
    add_linked(fragment, "done", "Or", {{"a", "clock.at_end"}, {"b", stopped}});
    return {.set_point = std::move(set_point),
            .done = expression::Signal::at("done.value"),
            .path_clock = "clock",
            .duration = motion.duration()};
  }

  [[nodiscard]] double stop_time(const ActuatorModel&) const override {
    return motion::PathClock(motion_.motion->clock, motion_.motion->duration(), false).stop_time_bound();
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states{"progress", "at_path", "error"};
    if (!motion_.handed_over.empty()) states.emplace_back("via_passed");
    return states;
  }
  [[nodiscard]] int via_count() const override { return static_cast<int>(motion_.handed_over.size()); }
  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    if (name == "progress") return "law.s";
    if (name == "at_path") return add_threshold(fragment, "law.s", parameters.value("fraction", 1.0), "at_path");
    if (name == "error") return add_error(fragment);
    const auto index = parameters.value("index", std::size_t{0});
    const double time = index < motion_.handed_over.size() ? motion_.handed_over[index] : motion_.motion->duration();
    return add_threshold(fragment, "clock.time", time, "via_passed");
  }

  [[nodiscard]] PlannedPath planned_path() const override {
    if (motion_.partner) return {};
    return {.motion = motion_.motion.get(), .X_FM = motion_.X_FM, .handed_over = motion_.handed_over};
  }
  [[nodiscard]] const PlannedMotion* planned_motion() const override { return &motion_; }
  [[nodiscard]] double duration() const override { return motion_.motion->duration(); }
  [[nodiscard]] BlendOut left_in_motion() const override {
    if (!motion_.leaving || motion_.clock_outputs.time.empty() || motion_.partner) return {};
    return {.motion = &motion_, .abort_handlers = motion_.leaving->abort_handlers};
  }
  [[nodiscard]] std::vector<device::Seam> begins() const override {
    // In motion it depends on when it takes over.
    if (motion_.motion->law.begins_in_motion()) return {};
    return at_rest(&motion::Motion::q_start);
  }
  [[nodiscard]] std::vector<device::Seam> ends() const override { return at_rest(&motion::Motion::q_goal); }

 private:
  /// Of each arm.
  [[nodiscard]] std::vector<device::Seam> at_rest(JointVector motion::Motion::*q) const {
    std::vector<device::Seam> seams{rest_at(*motion_.motion.*q)};
    if (motion_.partner) seams.push_back(rest_at(*motion_.partner->motion.*q));
    return seams;
  }

  /// The net fails where the arm is not at the start that the motion was planned from.
  void add_start_check(expression::FragmentWriter& fragment) const {
    fragment.add("at_start", "SnapshotBoolean", {{"trigger", true}});
    fragment.feed(motion_.begins_there->node(), "at_start.input");
    add_linked(fragment, "elsewhere", "Not", {{"input", "at_start.value"}});
    add_linked(fragment, "wrong_start", "Error", {{"condition", "elsewhere.value"}},
               {{"text", "the arm is not where its motion begins"}});
  }

  /// Goes on with another clock, and shows its own to the next motion.
  void add_hand_over(expression::FragmentWriter& fragment) const {
    if (motion_.motion->law.begins_in_motion()) fragment.set_parameter("clock", "in_motion", true);
    if (motion_.clock_initial.time) fragment.feed(motion_.clock_initial.time->node(), "clock.begin_time");
    if (motion_.clock_initial.rate) fragment.feed(motion_.clock_initial.rate->node(), "clock.begin_rate");
    for (const auto& [channel, port] :
         {std::pair(&motion_.clock_outputs.time, "time"), {&motion_.clock_outputs.rate, "rate"}}) {
      if (channel->empty()) continue;
      const std::string id = std::string("tell_") + port;
      add_linked(fragment, id, "OutputReal", {{"value", std::string("clock.") + port}}, {{"channel", *channel}});
    }
  }

  /// @return a Boolean that holds at and past a value.
  static std::string add_threshold(expression::FragmentWriter& fragment, const std::string& port, double value,
                                   const char* what) {
    std::string id = fmt::format("{}_{:g}", what, value);
    for (char& c : id) c = c == '.' ? '_' : c;
    while (fragment.has(id)) id += '_';
    add_linked(fragment, id, "AtLeast", {{"a", port}}, {{"b", value}});
    return id + ".value";
  }

  /// There are no joints for this cycle: what an arm is fed with, in the same fragment, is null.
  std::string add_error(expression::FragmentWriter& fragment) const {
    if (motion_.partner) {
      fragment.add("no_joints", "Or");
      fragment.link(fragment.add_null_test("arm_1.q", net::ValueType::kJoints), "no_joints.a");
      fragment.link(fragment.add_null_test("arm_2.q", net::ValueType::kJoints), "no_joints.b");
      return "no_joints.value";
    }
    const SetPointKind kind = kind_of(motion_.motion->path);
    add_linked(fragment, "no_joints", "IsNullJoints",
               {{"input", kind == SetPointKind::kJoints ? "path.q"
                          : kind == SetPointKind::kPose ? "inverse.q"
                                                        : "choose_q.value"}});
    return "no_joints.value";
  }

  PlannedMotion motion_;
};

/// Motions that are not planned yet.
class MotionModel : public ActionModel {
 public:
  explicit MotionModel(std::string name, SetPointKind gives) : name_(std::move(name)), gives_(gives) {}

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return gives_; }
  [[nodiscard]] std::vector<std::string> states() const override {
    return {"progress", "at_path", "via_passed", "error"};
  }
  [[nodiscard]] bool needs_plan() const override { return true; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter&, const ActuatorModel&) const override { return {}; }

 private:
  std::string name_;
  SetPointKind gives_;
};

motion::MotionOptions options_of(const motion::ArmModel& arm, const PlanParameters& parameters) {
  return {.velocity = parameters.velocity,
          .acceleration = parameters.acceleration,
          .linear_velocity = parameters.linear_velocity,
          .X_FM = arm.X_FM,
          .load = arm.load};
}

Result<motion::SequencePlan> alone(Result<motion::Motion> motion) {
  if (!motion) return std::unexpected(std::move(motion.error()));
  motion::SequencePlan plan;
  plan.motion = std::move(*motion);
  return plan;
}

/// Of one arm, with goals in its base.
class ArmMotion : public MotionModel {
 public:
  using Planner = std::function<Result<motion::SequencePlan>(const expression::MountedArm& arm,
                                                             const kinematics::JointVector& q_start)>;
  /// @param parameters  frame that moves, start, blend and inputs of the clock; the rest is the planner's
  ArmMotion(const char* name, PlanParameters parameters, Planner planner)
      : MotionModel(name, SetPointKind::kPath), parameters_(std::move(parameters)), planner_(std::move(planner)) {}

  [[nodiscard]] std::vector<device::Seam> begins() const override {
    return parameters_.from ? std::vector{rest_at(*parameters_.from)} : std::vector<device::Seam>();
  }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const expression::Places& q_start) const override {
    if (actuator.joint())
      return failure(Code::kInvalidValue, {}, fmt::format("C8: {} is not for '{}'", name(), actuator.name()),
                     "Use ptp() with a goal of one number");
    return planned_from(*actuator.arm(), actuator.devices().front(), q_start, planner_);
  }

 protected:
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> planned_from(const expression::MountedArm& arm,
                                                                        const std::string& device,
                                                                        const expression::Places& q_start,
                                                                        const Planner& planner) const {
    auto plan = planner(arm, q_start.at(device));
    if (!plan) return std::unexpected(std::move(plan.error()));
    PlannedMotion motion{.motion = std::make_shared<const motion::Motion>(std::move(plan->motion)),
                         .X_FM = parameters_.X_FM.value_or(arm.X_FT),
                         .handed_over = std::move(plan->handed_over),
                         .clock = parameters_.clock,
                         .name = std::string(name())};
    if (parameters_.from) motion.begins_there = stands_at(arm, device, *parameters_.from);
    if (parameters_.blend.kind != motion::Blend::Kind::kNone) {
      motion.leaving = {.blend = parameters_.blend};
      motion.clock_outputs = {.time = path_time_channel(device), .rate = path_rate_channel(device)};
    }
    return std::make_shared<const PlannedModel>(std::move(motion));
  }

 private:
  /// What was sent to the arm last is this.
  static expression::State stands_at(const expression::MountedArm& arm, const std::string& device,
                                     const JointVector& q) {
    const expression::JointsSensor sent(expression::read_resource(net::ValueType::kJoints, "ArmState", "device", device,
                                                                  arm.device, "set_point_q",
                                                                  expression::id_of("state", device)));
    return expression::near(sent, net::JointArray(q), arm.device->description().start_tolerance);
  }

  PlanParameters parameters_;
  Planner planner_;
};

/// A PTP; also of a single joint.
class PtpMotion final : public ArmMotion {
 public:
  PtpMotion(JointVector q_goal, const PlanParameters& parameters)
      : ArmMotion("PTP", parameters, {}), q_goal_(std::move(q_goal)), parameters_(parameters) {}

  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const expression::Places& q_start) const override {
    if (actuator.joint() && q_goal_.size() != 1)
      return failure(Code::kWrongSize, {}, fmt::format("a goal of {} joints for '{}'", q_goal_.size(), actuator.name()),
                     "Give one number");
    const auto planner = [&](const expression::MountedArm& arm, const JointVector& q) {
      const motion::ArmModel model = expression::planning_model(arm, parameters_.X_FM);
      return alone(motion::plan_ptp(model.chain, model.limits, q, goal(actuator, q), options_of(model, parameters_)));
    };
    return planned_from(*actuator.arm(), actuator.devices().front(), q_start, planner);
  }

 private:
  /// Of a single joint the others are at rest.
  [[nodiscard]] JointVector goal(const ActuatorModel& actuator, const JointVector& q) const {
    if (!actuator.joint()) return q_goal_;
    JointVector goal = q;
    goal[*actuator.joint()] = q_goal_[0];
    return goal;
  }

  JointVector q_goal_;
  PlanParameters parameters_;
};

/// With a planner of its own.
class SelfPlannedMotion final : public MotionModel {
 public:
  SelfPlannedMotion(std::string name, SetPointKind gives, MotionPlanner planner)
      : MotionModel(std::move(name), gives), planner_(std::move(planner)) {}

  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel&,
                                                                const expression::Places& q_start) const override {
    auto plan = planner_(q_start);
    if (!plan) return std::unexpected(std::move(plan.error()));
    return std::make_shared<const PlannedModel>(std::move(*plan));
  }

 private:
  MotionPlanner planner_;
};

/// The leg with the parameters of its motion.
motion::LegMaker with_parameters(const SequencePart& part) {
  return [part](const JointVector& q) -> Result<motion::Leg> {
    auto leg = part.geometry(q);
    if (!leg) return leg;
    leg->velocity = part.parameters.velocity;
    leg->acceleration = part.parameters.acceleration;
    leg->linear_velocity = part.parameters.linear_velocity;
    leg->blend = part.blend;
    return leg;
  };
}

Action motion_action(const char* name, const PlanParameters& parameters, ArmMotion::Planner planner) {
  return Action(std::make_shared<const ArmMotion>(name, parameters, std::move(planner)));
}

/// A motion of one leg; `make_leg(model, q, goal)` is one of the functions of core/motion/leg.h.
template <class Goal, class MakeLeg>
Action one_leg(const char* name, const PlanParameters& parameters, const Goal& goal, MakeLeg make_leg) {
  return motion_action(name, parameters,
                       [parameters, goal, make_leg](const expression::MountedArm& arm, const JointVector& q_start) {
                         const motion::ArmModel model = expression::planning_model(arm, parameters.X_FM);
                         const auto geometry = [&](const JointVector& q) { return make_leg(model, q, goal); };
                         return motion::plan_sequence(
                             model, q_start, {with_parameters({.geometry = geometry, .parameters = parameters})});
                       });
}

}  // namespace

Action planned_by(std::string name, SetPointKind gives, MotionPlanner planner) {
  return Action(std::make_shared<const SelfPlannedMotion>(std::move(name), gives, std::move(planner)));
}
Action planned(PlannedMotion motion) { return Action(std::make_shared<const PlannedModel>(std::move(motion))); }

Action ptp(const JointVector& q_goal, const PlanParameters& parameters) {
  return Action(std::make_shared<const PtpMotion>(q_goal, parameters));
}

Action lin(const Eigen::Isometry3d& X_BM_goal, const PlanParameters& parameters) {
  return motion_action("LIN", parameters,
                       [parameters, X_BM_goal](const expression::MountedArm& arm, const JointVector& q) {
                         const motion::ArmModel model = expression::planning_model(arm, parameters.X_FM);
                         if (!model.inverse)
                           return Result<motion::SequencePlan>(
                               failure(Code::kRequires, {}, "the arm has no inverse kinematics", "Use a PTP"));
                         return alone(motion::plan_lin(model.chain, *model.inverse, model.limits, model.cartesian, q,
                                                       X_BM_goal, {}, options_of(model, parameters)));
                       });
}

Action circ(const motion::ArcThrough& arc, const PlanParameters& parameters) {
  return one_leg("CIRC", parameters, arc,
                 [](const auto& arm, const auto& q, const auto& goal) { return motion::circ_leg(arm, q, goal); });
}
Action circ(const motion::ArcAbout& arc, const PlanParameters& parameters) {
  return one_leg("CIRC", parameters, arc,
                 [](const auto& arm, const auto& q, const auto& goal) { return motion::circ_leg(arm, q, goal); });
}
Action spline(const std::vector<Eigen::Isometry3d>& poses_BM, const PlanParameters& parameters) {
  return one_leg("spline", parameters, poses_BM,
                 [](const auto& arm, const auto& q, const auto& goal) { return motion::spline_leg(arm, q, goal); });
}
Action spline(const std::vector<JointVector>& points, const PlanParameters& parameters) {
  return one_leg("spline", parameters, points,
                 [](const auto& arm, const auto& q, const auto& goal) { return motion::spline_leg(arm, q, goal); });
}

Action sequence(std::vector<SequencePart> parts) {
  PlanParameters first = parts.empty() ? PlanParameters{} : parts.front().parameters;
  first.blend = parts.empty() ? motion::Blend{} : parts.back().parameters.blend;
  return motion_action("sequence", first,
                       [parts = std::move(parts), first](const expression::MountedArm& arm, const JointVector& q) {
                         if (parts.empty())
                           return Result<motion::SequencePlan>(
                               failure(Code::kMissing, {}, "a sequence without motions", "Give at least one"));
                         std::vector<motion::LegMaker> makers;
                         for (const SequencePart& part : parts) makers.push_back(with_parameters(part));
                         return motion::plan_sequence(expression::planning_model(arm, first.X_FM), q, makers);
                       });
}

namespace {

/// One action, if it needs a plan.
Diagnostics plan(CommandNode& node, const Result<expression::Places>& begin) {
  Diagnostics diagnostics;
  const ActionModel& action = node.action->model();
  if (!action.needs_plan() || node.actuator->model().fault()) return diagnostics;  // check() reports the fault
  if (!begin) return begin.error();
  const auto takes = node.actuator->model().takes();
  if (std::ranges::find(takes, action.gives(node.actuator->model())) == takes.end())
    return diagnostics;  // check() reports it
  for (const std::string& device : node.actuator->model().devices()) {
    if (begin->at(device).size() == 0)
      diagnostics.error(Code::kNotPossibleNow, {}, fmt::format("the position of '{}' is not known yet", device),
                        "Let the core run a cycle before");
  }
  if (diagnostics.has_errors()) return diagnostics;
  auto planned = action.plan(node.actuator->model(), *begin);
  if (!planned) return planned.error();
  node.planned = std::move(*planned);
  return diagnostics;
}

/// Where the arms are when a command begins: where its motion says that it begins, else where they were left.
Result<expression::Places> begin_of(const StartPositions& positions, const CommandNode& node, int i) {
  const auto begins = node.action->model().needs_plan() ? node.action->model().begins() : std::vector<device::Seam>();
  return begins.empty() ? positions.all_at_begin_of(i) : positions.all_at_given_begin(i, begins.front().q);
}

}  // namespace

Diagnostics plan(const Command& command) {
  expression::Places set_points;
  return plan(command, set_points);
}

Diagnostics plan(const Command& command, expression::Places& places, TreeEnd* end) {
  Diagnostics diagnostics;
  const CommandTree tree(command);
  if (!tree.cycle_of_starts().empty()) return diagnostics;  // check() reports it
  const std::vector<int> ranks = tree.ranks();
  std::vector<int> order(ranks.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) order[static_cast<std::size_t>(ranks[i])] = static_cast<int>(i);
  StartPositions start_positions(tree, places);
  for (const int i : order) {
    CommandNode& node = *tree.at(i).node;
    if (!node.is_runtime() || node.actuator->model().arms().empty()) continue;
    if (start_positions.follows_unplanned(i)) {
      start_positions.note_unplanned(i);
      continue;
    }
    const auto begin = begin_of(start_positions, node, i);
    if (Diagnostics faults = plan(node, begin); faults.has_errors()) {
      diagnostics.append(faults, tree.at(i).path);
      if (begin) start_positions.note_unplanned(i);
    } else {
      start_positions.note(i);
    }
  }
  places = start_positions.nominal_ends();
  if (end == nullptr) return diagnostics;
  for (const auto& [device, q] : places)
    if (auto rest = start_positions.end_of(device)) end->rest[device] = std::move(*rest);
  end->left = start_positions.left_in_motion();
  return diagnostics;
}

}  // namespace takt::command
