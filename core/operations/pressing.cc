#include "core/operations/pressing.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "core/activity/dual_entry_motion.h"
#include "core/command/single_net.h"
#include "core/expression/device_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"
#include "core/operations/touch.h"

namespace takt::activity {
namespace {

using command::State;

// -- The action -------------------------------------------------------------------------------------------------------

command::Action stiff_or_not(const Pressing& pressing, const command::Cell& cell, const command::Action& action) {
  if (!pressing.compliance) return action;
  const auto& chain = *cell.arms.find(pressing.arm)->second.device->description().chain;
  return with_compliance(action, wish_of(*pressing.compliance, chain.joint_count()));
}

command::Action alone(const Pressing& pressing, const PlannedPressing& planned, const command::Cell& cell,
                      const command::Biases& biases) {
  const auto force = command::pressing_force(cell, pressing.sensor, planned.direction_B, biases);
  return command::press(force, planned.direction_B, planned.wish);
}

/// A press whose way depends on where the arm is: planned when that is known.
class PlacedPress final : public command::ActionModel {
 public:
  PlacedPress(const Pressing& pressing, const command::Cell& cell, command::Biases biases)
      : pressing_(pressing), cell_(cell), biases_(std::move(biases)) {}

  [[nodiscard]] std::string_view name() const override { return pressing_.type; }
  [[nodiscard]] command::SetPointKind gives(const command::ActuatorModel&) const override {
    return command::SetPointKind::kTwist;
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    return {"in_contact", "touched", "at_force", "too_far", "error", "sunk", "path_ended"};
  }
  [[nodiscard]] bool needs_plan() const override { return true; }
  [[nodiscard]] command::Contribution add_to(command::FragmentWriter&, const command::ActuatorModel&) const override {
    return {};
  }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const command::ActuatorModel&,
                                                                const command::Places& q_start) const override {
    const auto planned = plan_pressing(pressing_, cell_at(cell_, q_start), q_start.at(pressing_.arm));
    if (!planned) return std::unexpected(planned.error());
    return alone(pressing_, *planned, cell_, biases_).shared_model();
  }

 private:
  const Pressing& pressing_;
  const command::Cell& cell_;
  command::Biases biases_;
};

command::Action press_action(const Pressing& pressing, const PlannedPressing& planned, const command::Cell& cell,
                             const command::Biases& biases) {
  return stiff_or_not(pressing, cell, alone(pressing, planned, cell, biases));
}

command::Action press_from_anywhere(const Pressing& pressing, const command::Cell& cell,
                                    const command::Biases& biases) {
  return stiff_or_not(pressing, cell, command::Action(std::make_shared<const PlacedPress>(pressing, cell, biases)));
}

// -- What ends it ----------------------------------------------------------------------------------------------------

/// What may happen to a press; where the tool stood then is kept.
enum class PressEvent : std::uint8_t { kTooFar, kSilent, kHeld, kFound, kPathEnded, kUntil, kTouched, kCancelled };

/// @param key  with which the names of what the command keeps begin
std::string observation_of(PressEvent event, const std::string& key) {
  static constexpr std::array<std::string_view, 8> kNames = {"too far",    "silent", "held",    "found",
                                                             "path ended", "until",  "touched", "end"};
  return fmt::format("{} {}", key, kNames.at(static_cast<std::size_t>(event)));
}

/// What has happened to a press that is over.
class PressHistory {
 public:
  PressHistory(const ActivityRun& run, std::string key) : run_(run), key_(std::move(key)) {}
  /// Where the tool stood in the arm's base, m; nothing: it has not happened.
  [[nodiscard]] std::optional<net::Frame> place(PressEvent event) const {
    return run_.value<net::Frame>(observation_of(event, key_));
  }
  [[nodiscard]] bool has(PressEvent event) const { return place(event).has_value(); }

 private:
  const ActivityRun& run_;
  std::string key_;
};

// -- The command, with all that ends it -------------------------------------------------------------------------------

/// A command and where each of its handlers comes from, below the operation.
struct MadePress {
  command::RuntimeCommand command;
  std::vector<std::string> handler_places;
};

/// @param key  with which the names of what it keeps begin
MadePress make_press(const Pressing& pressing, const std::string& name, const command::Action& action,
                     const command::Cell& cell, const command::Biases& biases, const std::string& key) {
  MadePress made{.command = command::RuntimeCommand(name, command::arm(cell, pressing.arm), action),
                 .handler_places = {}};
  command::RuntimeCommand& pressed = made.command;
  const command::FrameSensor tool = command::tool_pose(cell, pressing.arm);
  const auto keep = [&](PressEvent event, const State& state) {
    pressed.capture(observation_of(event, key), tool, state);
  };
  const auto ends = [&](PressEvent event, const State& state, const std::string& place) {
    pressed.on_entered(state, cancel(pressed));
    keep(event, state);
    made.handler_places.emplace_back(place);
  };
  using enum PressEvent;
  ends(kTooFar, action.state("too_far"), "/travel_m");
  ends(kSilent, action.state("error"), "/sensor");
  if (pressing.seconds) ends(kHeld, action.state("at_force").held_for(*pressing.seconds), "/seconds");
  if (pressing.drop) ends(kFound, action.state("sunk"), "/drop_m");
  if (pressing.path) ends(kPathEnded, action.state("path_ended"), pressing.path_key);
  if (pressing.until) ends(kUntil, command::state_of(*pressing.until, cell, biases), "/until");
  keep(kTouched, action.state("touched"));
  keep(kCancelled, pressed.cancelled());
  return made;
}

/// What has come of it once it has ended in order: the touch of its arm; diagnostics, with pointers below the
/// operation, if it has failed. @param cancelled  somebody has cancelled it, so that it may end anywhere
Diagnostics end_press(const Pressing& pressing, const PressHistory& history, bool cancelled, Context& context) {
  using enum PressEvent;
  Diagnostics diagnostics;
  const auto touched = history.place(kTouched), end = history.place(kCancelled);
  // Where the tool stood when it was to press no more, else where it touched, is the touch of this arm.
  if (touched) diagnostics.append(note_touch(context, pressing.arm, end ? *end : *touched));
  if (cancelled || history.has(kHeld) || history.has(kFound) || history.has(kUntil)) return diagnostics;
  if (history.has(kSilent)) {
    diagnostics.error(Code::kSensorSilent, "/sensor",
                      fmt::format("'{}' did not answer, so the arm stopped", pressing.sensor),
                      "check its power and its wiring");
  } else if (history.has(kTooFar)) {
    diagnostics.error(Code::kConditionNotMet, "/travel_m",
                      touched ? "the travel was used up after the touch" : "nothing was touched",
                      "a longer travel, another beginning or direction");
  } else if (history.has(kPathEnded) && pressing.path_end_fails) {
    diagnostics.error(Code::kConditionNotMet, "", "the pattern has come to its end and nothing was found",
                      "a larger radius, a smaller pitch, or \"on_end\": \"continue\"");
  }
  return diagnostics;
}

// -- As an activity ---------------------------------------------------------------------------------------------------

/// From rest, to nobody knows where.
class PressingActivity final : public ActivityModel {
 public:
  PressingActivity(const Pressing& pressing, command::Biases biases)
      : ActivityModel(pressing.name), pressing_(pressing), biases_(std::move(biases)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {pressing_.arm}; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const command::Cell& cell = planning.cell;
    const kinematics::JointVector& q = *planning.predecessors.find(pressing_.arm)->second.at_end.q;
    if (pressing_.compliance) {
      Diagnostics wrong = check_compliance(*pressing_.compliance, cell, actuators());
      if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    }
    const auto planned = plan_pressing(pressing_, cell, q);
    if (!planned) return std::unexpected(planned.error());
    PlannedActivity prepared;
    prepared.command = command_of(pressing_, *planned, cell, biases_);
    prepared.end_states[pressing_.arm] = {};
    prepared.begins[pressing_.arm].push_back(seam_at_rest(q));
    return prepared;
  }

  [[nodiscard]] static command::RuntimeCommand command_of(const Pressing& pressing, const PlannedPressing& planned,
                                                          const command::Cell& cell, const command::Biases& biases) {
    const command::Action action = press_action(pressing, planned, cell, biases);
    return make_press(pressing, pressing.name, action, cell, biases, {}).command;
  }

 private:
  Pressing pressing_;
  command::Biases biases_;
};

// -- As a step --------------------------------------------------------------------------------------------------------

class PressingRun final : public ScheduledRun {
 public:
  explicit PressingRun(const Pressing& pressing) : pressing_(pressing) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    return std::make_shared<const PressingActivity>(pressing_, context.variables.biases);
  }

  Progress finish(Context& context, Diagnostics& diagnostics) override {
    const Diagnostics failed = end_press(pressing_, {*run(), {}}, cancelled(), context);
    diagnostics.append(failed);
    return failed.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  const Pressing& pressing_;
};

class PressingStep final : public Step {
 public:
  explicit PressingStep(Pressing pressing) : pressing_(std::move(pressing)) {}

  /// Where the surface is shows only in the run: the arm is taken to stay where it begins.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.touched[pressing_.arm] = true;
    if (pressing_.compliance &&
        !rehearse_compliance(*pressing_.compliance, rehearsal, {pressing_.arm}, pointer, diagnostics))
      return;
    const auto planned = plan_pressing(pressing_, rehearsal.cell, rehearsal.q[pressing_.arm]);
    if (!planned) {
      diagnostics.append(planned.error(), pointer);
      return;
    }
    rehearsal.duration += pressing_.seconds.value_or(0.0);
    if (planned->wish.path) rehearsal.duration += planned->wish.path->duration();
    const auto command = PressingActivity::command_of(pressing_, *planned, rehearsal.cell, {});
    const auto mapped = command::single_net(command, pressing_.name);
    if (!mapped) return diagnostics.append(mapped.error(), pointer);
    rehearse_net(mapped->net, rehearsal, pointer, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<PressingRun>(pressing_); }

 private:
  Pressing pressing_;
};

// -- As a command -----------------------------------------------------------------------------------------------------

class PressingCommand final : public OperationCommand {
 public:
  explicit PressingCommand(Pressing pressing) : pressing_(std::move(pressing)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    const command::Action action = action_of(making);
    MadePress press = make_press(pressing_, name, action, making.cell, making.biases, key);
    MadeCommand made{.command = press.command,
                     .action = action,
                     .actuator = command::arm(making.cell, pressing_.arm),
                     .handler_places = std::move(press.handler_places)};
    if (pressing_.compliance) made.places = places_of(*pressing_.compliance);
    return made;
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.touched[pressing_.arm] = true;
    rehearsal.duration += pressing_.seconds.value_or(0.0);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool cancelled, Context& context,
              Diagnostics& diagnostics) const override {
    diagnostics.append(end_press(pressing_, {ended, key}, cancelled, context), pointer);
  }

 private:
  [[nodiscard]] command::Action action_of(const BuildContext& making) const {
    if (!pressing_.needs_place() && !moves(making.cell.frames, pressing_.in, pressing_.arm)) {
      const auto planned = plan_pressing(pressing_, making.cell, place_now(making.cell));
      if (planned) return press_action(pressing_, *planned, making.cell, making.biases);
    }
    return press_from_anywhere(pressing_, making.cell, making.biases);
  }
  /// Only springs that it does not bring along make a difference: how fast its law is.
  [[nodiscard]] kinematics::JointVector place_now(const command::Cell& cell) const {
    const command::MountedArm& mounted = cell.arms.find(pressing_.arm)->second;
    const kinematics::JointVector& q = mounted.set_point();
    return q.size() > 0 ? q : mounted.start;
  }

  Pressing pressing_;
};

}  // namespace

void check_pressing_sensor(const std::string& arm, const std::string& sensor, const ReadContext& from) {
  const auto found = from.cell.sensors.find(sensor);
  if (found == from.cell.sensors.end() || found->second.arm == arm) return;
  from.reader.diagnostics().error(Code::kConflict, from.reader.at("sensor"),
                                  fmt::format("'{}' is not on '{}'", sensor, arm), "a sensor on this arm");
}

std::unique_ptr<Step> pressing_step(Pressing pressing) { return std::make_unique<PressingStep>(std::move(pressing)); }

std::unique_ptr<OperationCommand> pressing_command(Pressing pressing) {
  return std::make_unique<PressingCommand>(std::move(pressing));
}

}  // namespace takt::activity
