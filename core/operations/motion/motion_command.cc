#include "core/operations/motion/motion_command.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/motion_options.h"
#include "core/activity/pair_motion.h"
#include "core/base/object_reader.h"
#include "core/command/actions/carried_motion.h"
#include "core/command/actions/motion_action.h"
#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/motion/motion_on_base.h"
#include "core/operations/motion/motion_plan.h"
#include "core/operations/motion/motion_verdict.h"
#include "core/operations/table/overlay.h"
#include "core/operations/table/touch.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using expression::State;
using kinematics::JointVector;
using Planned = Result<command::PlannedMotion>;

const char* name_of(PathKind kind) {
  switch (kind) {
    case PathKind::kPtp:
      return "PTP";
    case PathKind::kLin:
      return "LIN";
    case PathKind::kCirc:
      return "CIRC";
    case PathKind::kMove:
      return "move";
    default:
      return "spline";
  }
}

/// How its motions are carried out; none of them says it for itself.
struct WithCompliance {
  std::optional<ComplianceParameters> compliance;
};

/// One motion, or several that are blended into one.
class MotionCommand final : public OperationCommand {
 public:
  explicit MotionCommand(const std::optional<ComplianceParameters>& compliance)
      : OperationCommand(WithCompliance{compliance}) {}

  std::vector<MotionTask> requests;
  std::vector<std::string> places;  ///< of each motion, below the pointer of this
  Json steps = Json::array();       ///< each motion as the file has it

  using OperationCommand::compliance;
  [[nodiscard]] const std::string& arm() const { return requests.front().arm; }
  [[nodiscard]] const std::string& follower() const { return requests.front().follower; }

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    MadeCommand made = on_actuator(actuator(build.cell), with_overlay(build, motion(build)));
    const command::Action& action = *made.action;
    command::Command& moved = made.command;
    for (std::size_t i = 0; i < requests.size(); ++i) {
      const std::string theirs = requests.size() == 1 ? "" : pointer_segment(i);
      made.places.emplace_back(theirs + "/ramp", places[i] + "/weave/ramp_s");
      if (!theirs.empty()) made.places.emplace_back(theirs, places[i]);
    }
    moved.observe(key + " cancelled", expression::BooleanSensor(moved.cancelled().node()));
    moved.observe(key + " over", moved.completed() || moved.failed());
    if (first_offset(requests)) {
      const State silent = action.state("no_force");
      moved.on_entered(silent, cancel(moved));
      moved.fails_if(silent.once());
      moved.capture(key + " no force", expression::tool_pose(build.cell, arm()), silent);
      made.handler_places.push_back(offset_place() + "/sensor");
      const auto leaves = [&](const char* state, const char* what, const char* place) {
        const State left = action.state(state);
        moved.on_entered(left, cancel(moved));
        moved.fails_if(left.once());
        moved.capture(key + what, action.progress(), left);
        made.handler_places.push_back(offset_place() + place);
      };
      leaves("lost_contact", " lost", "/lost_max_s");
      if (force().off_max) leaves("off_force", " off force", "/off_force_max_s");
    }
    add_aborts(build, key, action, made);
    const auto& condition = requests.back().until;
    if (!condition) return made;
    const expression::FrameSensor touch = tool_in_room(build.cell);
    State until = expression::state_of(*condition, build.cell, build.biases);
    if (requests.size() > 1) until = until && action.via_passed(static_cast<int>(requests.size()) - 2);
    moved.on_entered(until, cancel(moved));
    made.handler_places.push_back(places.back() + "/until");
    moved.fails_if(activity::not_touched(until, requests.back().must_touch, moved));
    moved.capture(key + " touch", touch, until);
    moved.capture(key + " silent", touch, is_null(expression::BooleanSensor(until.node())));
    return made;
  }

  [[nodiscard]] IntendedContact meant_touch() const override {
    const auto offset = first_offset(requests);
    if (!requests.back().until && !offset && !compliance()) return {};
    IntendedContact touch{.devices = {arm()}, .ends = requests.back().until && !offset && !compliance()};
    if (!follower().empty()) touch.devices.insert(follower());
    if (!compliance()) touch.first_motion = offset.value_or(requests.size() - 1);
    return touch;
  }
  [[nodiscard]] ArmTools arm_tools() const override {
    return {{arm(), requests.front().tool, pointer + places.front()}};
  }
  [[nodiscard]] std::string left_arm() const override {
    return requests.back().blends() && !carried() ? moved_by(requests.front()) : std::string();
  }
  [[nodiscard]] Json left_steps() const override { return steps; }
  [[nodiscard]] OwnPaths own_paths() const override {
    OwnPaths own{.arm = arm()};
    for (const MotionTask& request : requests)
      if (request.kind == PathKind::kMove) own.pointers.push_back(request.pointer);
    return own;
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    for (const std::string& device : actuator(rehearsal.cell).model().devices()) rehearsal.touched[device] = false;
    rehearsal.touched[arm()] = requests.back().until.has_value();
  }

  void finish(const activity::RunView& ended, const std::string& key, bool cancelled, activity::Context& context,
              Diagnostics& diagnostics) const override {
    const activity::GuardedEnd end = end_of(ended, key, cancelled);
    diagnostics.append(motion_verdict(requests, end, [this](int motion) -> MotionPlace {
      return {.pointer = pointer + places[static_cast<std::size_t>(motion)]};
    }));
    if (!ended.was_true(key + " over") && !ended.was_true(key + " cancelled")) return;  // it was never started
    for (const std::string& device : actuator(context.cell).model().devices()) context.variables.touches.erase(device);
    if (!end.outcome.touched()) return;
    const net::Frame& X = *end.outcome.X_BT;
    diagnostics.append(carried() ? note_touch_in_room(context, arm(), X) : note_touch(context, arm(), X), pointer);
  }

 private:
  [[nodiscard]] static std::string abort_name(const std::string& key, std::size_t part) {
    return fmt::format("{} unless {}", key, part);
  }
  /// What must not hold cancels it, each while its motion is being done.
  void add_aborts(const BuildContext& build, const std::string& key, const command::Action& action,
                  MadeCommand& made) const {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      if (!requests[i].abort_if) continue;
      State holds = expression::state_of(*requests[i].abort_if, build.cell, build.biases);
      if (i > 0) holds = holds && action.via_passed(static_cast<int>(i) - 1);
      if (i + 1 < requests.size()) holds = holds && !action.via_passed(static_cast<int>(i));
      made.command.on_entered(holds, cancel(made.command));
      made.command.fails_if(activity::not_allowed(holds, made.command));
      made.handler_places.push_back(places[i] + "/abort_if");
      made.command.capture(abort_name(key, i), action.progress(), holds);
      activity::capture_compared(made.command, holds, abort_name(key, i));
      made.command.capture(abort_name(key, i) + " silent", action.progress(),
                           is_null(expression::BooleanSensor(holds.node())));
    }
  }
  [[nodiscard]] activity::GuardedEnd end_of(const activity::RunView& ended, const std::string& key,
                                            bool cancelled) const {
    using enum activity::GuardedOutcome::Kind;
    activity::GuardedEnd end;
    end.no_force = ended.value<net::Frame>(key + " no force").has_value();
    if (const auto at = ended.value<net::Real>(key + " lost")) end.lost = *at;
    if (const auto at = ended.value<net::Real>(key + " off force")) end.off_force = *at;
    for (std::size_t i = 0; i < requests.size(); ++i) {
      const bool held = ended.value<net::Real>(abort_name(key, i)).has_value();
      const bool silent = !held && ended.value<net::Real>(abort_name(key, i) + " silent").has_value();
      if (held || silent)
        end.broken = {.motion = static_cast<int>(i),
                      .silent = silent,
                      .compared = activity::compared_text(ended, abort_name(key, i))};
    }
    if (!requests.back().until) return end;
    const bool was_cancelled = ended.was_true(key + " cancelled");
    if (const auto X = ended.value<net::Frame>(key + " touch")) {
      end.outcome = {.kind = kTouched, .X_BT = X};
    } else if (ended.value<net::Frame>(key + " silent")) {
      end.outcome.kind = kSensorSilent;
    } else if (ended.was_true(key + " over") && !was_cancelled && !cancelled) {
      end.outcome.kind = kNotTouched;
    }
    return end;
  }
  /// The arm is on a base that drives with it.
  [[nodiscard]] bool carried() const { return requests.front().base_goal.has_value(); }
  [[nodiscard]] command::Actuator actuator(const expression::Cell& cell) const {
    if (carried()) return command::arm_on_base(cell, arm());
    return follower().empty() ? command::arm(cell, arm()) : command::arm_pair(cell, arm(), follower());
  }
  /// Where the tool is, in the arm's base; of an arm whose base drives, in the world.
  [[nodiscard]] expression::FrameSensor tool_in_room(const expression::Cell& cell) const {
    const expression::FrameSensor X_BT = expression::tool_pose(cell, arm());
    return carried() ? expression::pose_between(cell, arm(), std::string(world::FrameGraph::kWorld)) * X_BT : X_BT;
  }
  [[nodiscard]] command::Action motion(const BuildContext& build) const {
    if (carried()) return motion_on_base(build);
    return follower().empty() ? motion_alone(build) : pair_motion(build);
  }
  [[nodiscard]] command::Action motion_on_base(const BuildContext& build) const {
    return command::planned_by(kind(), command::SetPointKind::kPair,
                               [this, &cell = build.cell](const expression::Places& q_start) {
                                 return plan_on_base(requests.front(), cell, q_start);
                               });
  }
  /// Planned when everything before it is, with machines where they are then.
  [[nodiscard]] command::Action motion_alone(const BuildContext& build) const {
    return command::planned_by(kind(), command::SetPointKind::kPath, [this, build](const expression::Places& q_start) {
      const expression::Cell cell = expression::cell_at(build.cell, q_start);
      Surroundings around = surroundings_at(cell, q_start, build.widths);
      around.meanwhile = build.meanwhile;
      auto plan = plan_motions(requests, cell, q_start.at(arm()), around);
      if (!plan) return Planned(placed(plan.error()));
      build.notes.append(plan->notes);
      command::PlannedMotion motion{.motion = std::make_shared<const motion::Motion>(std::move(plan->motion)),
                                    .X_FM = cell.arms.find(arm())->second.X_FT,
                                    .handed_over = std::move(plan->handed_over),
                                    .name = kind()};
      leave_in_motion(build, motion);
      return Planned(std::move(motion));
    });
  }
  /// The motion after the transaction may go on with it.
  void leave_in_motion(const BuildContext& build, command::PlannedMotion& motion) const {
    const MotionTask& last = requests.back();
    if (left_arm().empty() || !build.cell.channels.contains(command::path_time_channel(arm()))) return;
    motion.clock_outputs = {.time = command::path_time_channel(arm()), .rate = command::path_rate_channel(arm())};
    motion.leaving = {.blend = last.blend.along_path};
    if (last.abort_if) motion.leaving->abort_if = expression::state_of(*last.abort_if, build.cell, build.biases);
    motion.leaving->abort_handlers =
        static_cast<int>(std::ranges::count_if(requests, [](const auto& one) { return one.abort_if.has_value(); }));
  }
  /// Of two arms as one, which hold what they move as they stand where it begins.
  [[nodiscard]] command::Action pair_motion(const BuildContext& build) const {
    return command::planned_by(kind(), command::SetPointKind::kPair, [this, build](const expression::Places& q_start) {
      const expression::Cell cell = expression::cell_at(build.cell, q_start);
      const JointVector &q = q_start.at(arm()), &q_follower = q_start.at(follower());
      const auto grasp = activity::grasp_at(cell, arm(), follower(), q, q_follower);
      if (!grasp) return Planned(placed(grasp.error()));
      auto plan = plan_pair_motions(requests, cell, activity::pair_of(cell, *grasp), q, q_follower);
      if (!plan) return Planned(placed(plan.error()));
      build.notes.append(plan->notes);
      return Planned(activity::planned(*grasp, kind(), std::move(*plan)));
    });
  }
  [[nodiscard]] const char* kind() const { return requests.size() == 1 ? name_of(requests.front().kind) : "motions"; }
  /// Diagnostics of a plan, below the pointer of this.
  [[nodiscard]] std::unexpected<Diagnostics> placed(const Diagnostics& diagnostics) const {
    Diagnostics below;
    below.append(diagnostics, places.front());
    return std::unexpected(std::move(below));
  }

  [[nodiscard]] command::Action with_overlay(const BuildContext& build, command::Action motion) const {
    if (std::ranges::any_of(requests, [](const auto& request) { return request.weave.has_value(); }))
      motion = command::weave_each(motion, weaves_of(requests));
    if (const auto first = first_offset(requests))
      motion = command::force_offset(motion, force().pressing(arm(), build.cell, build.biases),
                                     force().control_parameters(build.cell), *first);
    return motion;
  }
  /// Of a motion that has one.
  [[nodiscard]] const ForceOffsetParameters& force() const { return *requests[*first_offset(requests)].force_offset; }
  [[nodiscard]] std::string offset_place() const { return places[*first_offset(requests)] + "/force_offset"; }
};

/// One arm, or the same two as one.
void check_movers(const MotionCommand& command, const std::string& pointer, Diagnostics& diagnostics) {
  const MotionTask& first = command.requests.front();
  for (std::size_t i = 0; i < command.requests.size(); ++i) {
    const MotionTask& request = command.requests[i];
    const std::string place = pointer + command.places[i];
    if (request.arm != first.arm) {
      diagnostics.error(Code::kConflict, place + "/arm", fmt::format("'{}' after '{}'", request.arm, first.arm),
                        "Use one arm for all of them");
    } else if (request.tool != first.tool) {
      diagnostics.error(Code::kConflict, place + "/tool", "another tool than that of the motion before it",
                        "Use one tool and one tool centre point for all of them");
    } else if (request.follower != first.follower) {
      const auto movers = [](const MotionTask& one) {
        return one.follower.empty() ? fmt::format("'{}' alone", one.arm)
                                    : fmt::format("'{}' and '{}' as one", one.arm, one.follower);
      };
      diagnostics.error(Code::kConflict, place + (request.follower.empty() ? "" : "/follower"),
                        fmt::format("{} after {}", movers(request), movers(first)),
                        "Give the same 'follower' at all of them");
    }
  }
  if (command.compliance() && !first.follower.empty())
    check_springs_of_two(*command.compliance(), pointer, diagnostics);
}

}  // namespace

std::unique_ptr<OperationCommand> motion_command(MotionTask motion, const OperationSource& source) {
  auto command = std::make_unique<MotionCommand>(motion.compliance);
  command->requests.push_back(std::move(motion));
  command->places.emplace_back();
  command->steps.push_back(source.json);
  return command;
}

namespace {

const std::vector<ParameterInfo>& motions_parameter_list() {
  static const std::vector<ParameterInfo> list = [] {
    ParameterInfo steps{
        .key = "steps", .type = ParameterInfo::Type::kObject, .definition = "motion_steps", .required = true};
    steps.doc = "Planned motions (ptp, lin, circ, spline, move), each but the last blended into the next.";
    return std::vector{steps, compliance_parameter()};
  }();
  return list;
}

std::unique_ptr<OperationCommand> read_motions(const OperationSource& source) {
  const auto& [json, pointer, cell, diagnostics] = source;
  static constexpr std::pair<const char*, PathKind> kKinds[] = {{"ptp", PathKind::kPtp},
                                                                {"lin", PathKind::kLin},
                                                                {"circ", PathKind::kCirc},
                                                                {"spline", PathKind::kSpline},
                                                                {"move", PathKind::kMove}};
  ObjectReader reader(json, pointer, diagnostics);
  (void)reader.text("do");
  (void)read_name(reader, "");
  auto command = std::make_unique<MotionCommand>(read_compliance(reader));
  const Json* steps = reader.array("steps");
  for (std::size_t i = 0; steps != nullptr && i < steps->size(); ++i) {
    const Json& step = (*steps)[i];
    const std::string place = "/steps" + pointer_segment(i), at = pointer + place;
    const Json word = step.is_object() ? step.value("do", Json()) : Json();
    const auto* kind = std::ranges::find_if(kKinds, [&](const auto& one) { return word == one.first; });
    if (kind == std::end(kKinds)) {
      diagnostics.error(Code::kUnknownName, pointer + place + "/do",
                        fmt::format("{} is not a planned motion", short_dump(word)),
                        "Use ptp, lin, circ, spline or move");
      continue;
    }
    Json alone = step;
    if (alone.erase("base_to") > 0)
      diagnostics.error(Code::kConflict, at + "/base_to", "a motion with a base is not blended",
                        "Give the motion a 'lin' of its own");
    command->requests.push_back(read_motion(kind->second, {alone, at, cell, diagnostics}));
    command->places.push_back(place);
    command->steps.push_back(step);
  }
  reader.finish();
  if (command->requests.empty()) {
    diagnostics.error(Code::kMissing, pointer + "/steps", "no motion is given", "Give at least one");
    command->requests.emplace_back();
    command->places.emplace_back();
  }
  check_movers(*command, pointer, diagnostics);
  const Diagnostics mixed = check_offsets(command->requests);
  for (Diagnostic diagnostic : mixed.list()) {
    diagnostic.pointer = pointer + "/steps" + diagnostic.pointer;
    diagnostics.add(std::move(diagnostic));
  }
  for (std::size_t i = 0; i < command->requests.size(); ++i) {
    const MotionTask& request = command->requests[i];
    const bool last = i + 1 == command->requests.size(), blends = request.blends();
    if (request.compliance)
      diagnostics.error(Code::kConflict, pointer + command->places[i] + "/compliance",
                        "one motion of several has another compliance",
                        "Give 'compliance' beside 'steps', for all of them");
    if (!last && request.until)
      diagnostics.error(Code::kConflict, pointer + command->places[i] + "/until",
                        "only the last of them may be guarded", "Give it on the last");
    if (!last && !blends && steps != nullptr && !steps->empty())
      diagnostics.error(Code::kConflict, pointer + command->places[i], "a motion that is not blended into the next",
                        "Give 'blend_m' or 'blend_fraction' on all but the last");
  }
  return command;
}

}  // namespace

Operation motions_operation() {
  return {.name = "motions",
          .doc = "Several planned motions of one arm, blended into one; only inside of a transaction.",
          .parameters = motions_parameter_list,
          .read_command = read_motions};
}

}  // namespace takt::operations
