#include "core/operations/press_command.h"

#include <utility>

#include <fmt/format.h>

#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/touch.h"

namespace takt::activity {
namespace {

using command::State;

command::Action stiff_or_not(const ForceRequest& request, const command::Cell& cell, const command::Action& action) {
  if (!request.compliance) return action;
  const auto& chain = *cell.arms.find(request.arm)->second.device->description().chain;
  return with_compliance(action, wish_of(*request.compliance, chain.joint_count()));
}

command::Action alone(const ForceRequest& request, const PreparedPress& prepared, const command::Cell& cell,
                      const command::Biases& biases) {
  const auto pressing = command::pressing_force(cell, request.sensor, prepared.direction_B, biases);
  return command::press(pressing, prepared.direction_B, prepared.wish);
}

/// A press whose way depends on where the arm is: planned when that is known.
class PlacedPress final : public command::ActionModel {
 public:
  PlacedPress(const ForceRequest& request, const command::Cell& cell, command::Biases biases)
      : request_(request), cell_(cell), biases_(std::move(biases)) {}

  [[nodiscard]] std::string_view name() const override { return request_.pattern ? "search" : "press"; }
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
    const auto prepared = prepare_press(request_, cell_at(cell_, q_start), q_start.at(request_.arm));
    if (!prepared) return std::unexpected(prepared.error());
    return alone(request_, *prepared, cell_, biases_).shared_model();
  }

 private:
  const ForceRequest& request_;
  const command::Cell& cell_;
  command::Biases biases_;
};

}  // namespace

command::Action press_action(const ForceRequest& request, const PreparedPress& prepared, const command::Cell& cell,
                             const command::Biases& biases) {
  return stiff_or_not(request, cell, alone(request, prepared, cell, biases));
}

command::Action press_from_anywhere(const ForceRequest& request, const command::Cell& cell,
                                    const command::Biases& biases) {
  return stiff_or_not(request, cell, command::Action(std::make_shared<const PlacedPress>(request, cell, biases)));
}

PressingCommand pressing_command(const ForceRequest& request, const std::string& name, const command::Action& action,
                                 const command::Cell& cell, const command::Biases& biases, const std::string& key) {
  PressingCommand made{.command = command::RuntimeCommand(name, command::arm(cell, request.arm), action),
                       .handler_places = {}};
  command::RuntimeCommand& pressed = made.command;
  const command::FrameSensor tool = command::tool_pose(cell, request.arm);
  const auto ends = [&](const char* what, const State& state, const char* place) {
    pressed.on_entered(state, cancel(pressed));
    pressed.capture(key + what, tool, state);
    made.handler_places.emplace_back(place);
  };
  ends(" too far", action.state("too_far"), "/travel_m");
  ends(" silent", action.state("error"), "/sensor");
  if (request.hold) ends(" held", action.state("at_force").held_for(*request.hold), "/seconds");
  if (request.drop) ends(" found", action.state("sunk"), "/drop_m");
  if (request.pattern) ends(" path ended", action.state("path_ended"), "/pattern");
  if (request.until) ends(" until", command::state_of(*request.until, cell, biases), "/until");
  pressed.capture(key + " touched", tool, action.state("touched"));
  pressed.capture(key + " end", tool, pressed.cancelled());
  return made;
}

Diagnostics end_pressing(const ForceRequest& request, const KeptPlaces& kept, const std::string& key, bool cancelled,
                         Context& context) {
  const auto was = [&](const char* what) { return kept(key + what).has_value(); };
  Diagnostics diagnostics;
  const auto touched = kept(key + " touched"), end = kept(key + " end");
  // Where the tool stood when it was to press no more, else where it touched, is the touch of this arm.
  if (touched) diagnostics.append(note_touch(context, request.arm, end ? *end : *touched));
  if (cancelled || was(" held") || was(" found") || was(" until")) return diagnostics;
  if (was(" silent")) {
    diagnostics.error(Code::kSensorSilent, "/sensor",
                      fmt::format("'{}' did not answer, so the arm stopped", request.sensor),
                      "check its power and its wiring");
  } else if (was(" too far")) {
    diagnostics.error(Code::kConditionNotMet, "/travel_m",
                      touched ? "the travel was used up after the touch" : "nothing was touched",
                      "a longer travel, another beginning or direction");
  } else if (was(" path ended") && request.must_find) {
    diagnostics.error(Code::kConditionNotMet, "", "the pattern has come to its end and nothing was found",
                      "a larger radius, a smaller pitch, or \"on_end\": \"continue\"");
  }
  return diagnostics;
}

}  // namespace takt::activity
