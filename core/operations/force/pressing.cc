#include "core/operations/force/pressing.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "core/expression/device_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/table/touch.h"

namespace takt::operations {
namespace {

using expression::State;

// -- The action -------------------------------------------------------------------------------------------------------

command::Action press_action(const Pressing& pressing, const PlannedPressing& planned, const expression::Cell& cell,
                             const expression::Biases& biases) {
  const auto force = command::pressing_force(cell, pressing.sensor, planned.direction_B, biases);
  command::PressControlParameters control = planned.control;
  if (pressing.lateral)
    control.lateral = {command::lateral_force(cell, pressing.sensor, planned.direction_B, biases), *pressing.lateral};
  return command::press(force, planned.direction_B, control);
}

/// A press that depends on where the arm is: planned when that is known.
class UnplannedPress final : public command::ActionModel {
 public:
  UnplannedPress(const Pressing& pressing, const expression::Cell& cell, expression::Biases biases)
      : pressing_(pressing), cell_(cell), biases_(std::move(biases)) {}

  [[nodiscard]] std::string_view name() const override { return pressing_.type; }
  [[nodiscard]] command::SetPointKind gives(const command::ActuatorModel&) const override {
    return command::SetPointKind::kTwist;
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    return {"in_contact", "touched", "at_force", "too_far", "error", "sunk", "too_deep", "sideways", "path_ended"};
  }
  [[nodiscard]] bool needs_plan() const override { return true; }
  [[nodiscard]] command::Contribution add_to(expression::FragmentWriter&,
                                             const command::ActuatorModel&) const override {
    return {};
  }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const command::ActuatorModel&,
                                                                const expression::Places& q_start) const override {
    const auto planned = plan_pressing(pressing_, expression::cell_at(cell_, q_start), q_start.at(pressing_.arm));
    if (!planned) return std::unexpected(planned.error());
    return press_action(pressing_, *planned, cell_, biases_).shared_model();
  }

 private:
  const Pressing& pressing_;
  const expression::Cell& cell_;
  expression::Biases biases_;
};

// -- What ends it ----------------------------------------------------------------------------------------------------

/// What may happen to a press; where the tool stood then is kept.
enum class PressEvent : std::uint8_t {
  kTooFar,
  kSilent,
  kHeld,
  kFound,
  kPathEnded,
  kUntil,
  kTouched,
  kCancelled,
  kTooDeep,
  kSideways
};

/// @param key  with which the names of what the command keeps begin
std::string observation_of(PressEvent event, const std::string& key) {
  static constexpr std::array<std::string_view, 10> kNames = {"too far", "silent",  "held", "found",    "path ended",
                                                              "until",   "touched", "end",  "too deep", "sideways"};
  return fmt::format("{} {}", key, kNames.at(static_cast<std::size_t>(event)));
}

/// What has happened to a press that is over.
class PressHistory {
 public:
  PressHistory(const activity::RunView& run, std::string key) : run_(run), key_(std::move(key)) {}
  /// Where the tool stood in the arm's base, m; nothing: it has not happened.
  [[nodiscard]] std::optional<net::Frame> place(PressEvent event) const {
    return run_.value<net::Frame>(observation_of(event, key_));
  }
  [[nodiscard]] bool has(PressEvent event) const { return place(event).has_value(); }
  /// What was wanted counts before what happened in the same cycle.
  [[nodiscard]] PressOutcome outcome() const {
    static constexpr std::array<std::pair<PressEvent, PressOutcome>, 8> kOrder{
        {{PressEvent::kHeld, PressOutcome::kHeld},
         {PressEvent::kFound, PressOutcome::kFound},
         {PressEvent::kUntil, PressOutcome::kConditionMet},
         {PressEvent::kSilent, PressOutcome::kSensorSilent},
         {PressEvent::kSideways, PressOutcome::kPushedSideways},
         {PressEvent::kTooDeep, PressOutcome::kDeeper},
         {PressEvent::kTooFar, PressOutcome::kTravelUsedUp},
         {PressEvent::kPathEnded, PressOutcome::kPathEnded}}};
    for (const auto& [event, outcome] : kOrder) {
      if (!has(event)) continue;
      const bool touched = outcome != PressOutcome::kTravelUsedUp || has(PressEvent::kTouched);
      return touched ? outcome : PressOutcome::kNotTouched;
    }
    if (activity::abort_diagnostics(run_, key_).has_errors()) return PressOutcome::kAborted;
    if (has(PressEvent::kCancelled) || run_.state() == activity::RunState::kCancelled)
      return PressOutcome::kInterrupted;
    return run_.failure() == activity::RunFailure::kNone ? PressOutcome::kRunning : PressOutcome::kStopped;
  }

 private:
  activity::RunView run_;
  std::string key_;
};

/// Why an outcome is a failure, with pointers below the operation; empty: it is none.
Diagnostics failure_of(const Pressing& pressing, PressOutcome outcome) {
  Diagnostics diagnostics;
  switch (outcome) {
    case PressOutcome::kSensorSilent:
      diagnostics.error(Code::kSensorSilent, "/sensor",
                        fmt::format("'{}' did not answer, so the arm stopped", pressing.sensor),
                        "Check its power and its wiring");
      break;
    case PressOutcome::kPushedSideways:
      diagnostics.error(Code::kConditionNotMet, "/lateral_max_N",
                        fmt::format("the force across the direction was more than {:g} N", *pressing.lateral),
                        "Choose another pose or direction, or increase the bound");
      break;
    case PressOutcome::kDeeper:
      diagnostics.error(Code::kConditionNotMet, "/depth_max_m",
                        fmt::format("the tool went more than {:g} m beyond the touch", *pressing.depth),
                        "Check what was touched, or increase the depth");
      break;
    case PressOutcome::kNotTouched:
    case PressOutcome::kTravelUsedUp:
      diagnostics.error(
          Code::kConditionNotMet, "/travel_m",
          outcome == PressOutcome::kNotTouched ? "nothing was touched" : "the travel was used up after the touch",
          "Increase travel_m, or start nearer to the surface or in another direction");
      break;
    case PressOutcome::kPathEnded:
      if (pressing.path_end_fails)
        diagnostics.error(Code::kConditionNotMet, "", "the pattern has come to its end and nothing was found",
                          "Increase the radius, decrease the pitch, or set \"on_end\": \"continue\"");
      break;
    default:
      break;
  }
  return diagnostics;
}

/// What has come of it once it has ended in order: the touch of its arm; diagnostics, with pointers below the
/// operation, if it has failed. @param cancelled  it was cancelled, so it may end anywhere
Diagnostics end_press(const Pressing& pressing, const PressHistory& history, bool cancelled,
                      activity::Context& context) {
  using enum PressEvent;
  Diagnostics diagnostics;
  const auto touched = history.place(kTouched), end = history.place(kCancelled);
  // Where the tool stood when it was to press no more, else where it touched, is the touch of this arm.
  if (touched) diagnostics.append(note_touch(context, pressing.arm, end ? *end : *touched));
  if (!cancelled) diagnostics.append(failure_of(pressing, history.outcome()));
  return diagnostics;
}

// -- The command, with all that ends it -------------------------------------------------------------------------------

class PressingCommand final : public OperationCommand {
 public:
  explicit PressingCommand(Pressing pressing) : OperationCommand(pressing), pressing_(std::move(pressing)) {}

  [[nodiscard]] IntendedContact meant_touch() const override { return {.devices = {pressing_.arm}}; }

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    const command::Action action = action_of(build);
    MadeCommand made = on_actuator(command::arm(build.cell, pressing_.arm), action);
    const expression::FrameSensor tool = expression::tool_pose(build.cell, pressing_.arm);
    const auto keep = [&](PressEvent event, const State& state) {
      made.command.capture(observation_of(event, key), tool, state);
    };
    const auto ends = [&](PressEvent event, const State& state, const std::string& place) {
      made.command.on_entered(state, cancel(made.command));
      keep(event, state);
      made.handler_places.emplace_back(place);
    };
    const command::Action& press = *made.action;
    State failed = press.state("too_far") || press.state("error");
    if (pressing_.path && pressing_.path_end_fails) failed = failed || press.state("path_ended");
    if (pressing_.depth) failed = failed || press.state("too_deep");
    if (pressing_.lateral) failed = failed || press.state("sideways");
    failed = failed.once();
    for (const State& wanted : wanted_ends(build, made)) failed = failed && !wanted.once();
    made.command.fails_if(failed);
    using enum PressEvent;
    ends(kTooFar, press.state("too_far"), "/travel_m");
    ends(kSilent, press.state("error"), "/sensor");
    if (const auto held = seconds()) ends(kHeld, press.state("at_force").held_for(*held), "/seconds");
    if (pressing_.drop) ends(kFound, press.state("sunk"), "/drop_m");
    if (pressing_.path) ends(kPathEnded, press.state("path_ended"), pressing_.path_key);
    if (pressing_.depth) ends(kTooDeep, press.state("too_deep"), "/depth_max_m");
    if (pressing_.lateral) ends(kSideways, press.state("sideways"), "/lateral_max_N");
    if (pressing_.until) ends(kUntil, expression::state_of(*pressing_.until, build.cell, build.biases), "/until");
    keep(kTouched, press.state("touched"));
    keep(kCancelled, made.command.cancelled());
    return made;
  }

  /// Where the surface is shows only in the run: the rehearsal goes on from where it begins.
  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.touched[pressing_.arm] = true;
    rehearsal.duration += seconds().value_or(0.0);
  }

  void finish(const activity::RunView& ended, const std::string& key, bool cancelled, activity::Context& context,
              Diagnostics& diagnostics) const override {
    diagnostics.append(end_press(pressing_, {ended, key}, cancelled, context), pointer);
  }

 private:
  /// What was wanted counts before what happened in the same cycle (PressHistory::outcome()).
  [[nodiscard]] std::vector<State> wanted_ends(const BuildContext& build, const MadeCommand& made) const {
    std::vector<State> ends;
    if (const auto held = seconds()) ends.push_back(made.action->state("at_force").held_for(*held));
    if (pressing_.drop) ends.push_back(made.action->state("sunk"));
    if (pressing_.until)
      ends.push_back(expression::state_of(*pressing_.until, build.cell, build.biases) && made.command.active());
    return ends;
  }
  /// For how long the force is held: in a transaction something else may end it.
  [[nodiscard]] std::optional<double> seconds() const {
    return pressing_.seconds || parent() != nullptr ? pressing_.seconds : pressing_.seconds_alone;
  }
  [[nodiscard]] command::Action action_of(const BuildContext& build) const {
    if (!pressing_.needs_place() && !expression::moves(build.cell.frames, pressing_.in, pressing_.arm)) {
      const auto planned = plan_pressing(pressing_, build.cell, place_now(build.cell));
      if (planned) return press_action(pressing_, *planned, build.cell, build.biases);
    }
    return command::Action(std::make_shared<const UnplannedPress>(pressing_, build.cell, build.biases));
  }
  /// Only springs that it does not bring along make a difference: how fast its law is.
  [[nodiscard]] kinematics::JointVector place_now(const expression::Cell& cell) const {
    const expression::MountedArm& mounted = cell.arms.find(pressing_.arm)->second;
    const kinematics::JointVector& q = mounted.set_point();
    return q.size() > 0 ? q : mounted.start;
  }

  Pressing pressing_;
};

}  // namespace

PressOutcome press_outcome(const activity::RunView& run, const std::string& key) {
  (void)run.failure();  // who asks for the outcome knows of it
  if (!key.empty()) return PressHistory(run, key).outcome();
  for (const char* type : {"/press", "/search", "/wipe"}) {
    const std::string touched = observation_of(PressEvent::kTouched, type);
    if (run.observes(touched)) return PressHistory(run.narrowed_to(touched), type).outcome();
  }
  return PressHistory(run, pointer_segment(run.name())).outcome();
}

std::string_view name_of(PressOutcome outcome) {
  switch (outcome) {
    case PressOutcome::kRunning:
      return "running";
    case PressOutcome::kHeld:
      return "held";
    case PressOutcome::kFound:
      return "found";
    case PressOutcome::kConditionMet:
      return "condition met";
    case PressOutcome::kPathEnded:
      return "path ended";
    case PressOutcome::kNotTouched:
      return "not touched";
    case PressOutcome::kTravelUsedUp:
      return "travel used up";
    case PressOutcome::kDeeper:
      return "deeper than expected";
    case PressOutcome::kPushedSideways:
      return "pushed sideways";
    case PressOutcome::kSensorSilent:
      return "sensor silent";
    case PressOutcome::kAborted:
      return "aborted";
    case PressOutcome::kStopped:
      return "stopped";
    case PressOutcome::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

void check_pressing_sensor(const std::string& arm, const std::string& sensor, const ReadContext& from) {
  const auto found = from.cell.sensors.find(sensor);
  // Of a cell that could not be built only names are known.
  if (found == from.cell.sensors.end() || found->second.arm.empty() || found->second.arm == arm) return;
  from.reader.diagnostics().error(Code::kConflict, from.reader.at("sensor"),
                                  fmt::format("'{}' is not on '{}'", sensor, arm), "Name a sensor on this arm");
}

std::unique_ptr<OperationCommand> pressing_command(Pressing pressing) {
  return std::make_unique<PressingCommand>(std::move(pressing));
}

}  // namespace takt::operations
