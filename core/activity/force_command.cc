// Contact forces as commands of a transaction.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/command_request.h"
#include "core/activity/force_request.h"
#include "core/activity/goal.h"
#include "core/activity/moving_frames.h"
#include "core/activity/touch.h"
#include "core/base/object_reader.h"
#include "core/command/condition_state.h"
#include "core/command/device_sensors.h"
#include "core/command/press_action.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using command::State;

command::Action press_of(const ForceRequest& request, const PreparedPress& prepared, const command::Cell& cell,
                         const command::Biases& biases) {
  command::PressWish wish = command::press_wish(prepared.command, cell);
  wish.path = prepared.path;
  const Eigen::Vector3d& direction_B = prepared.command.direction_B;
  return command::press(command::pressing_force(cell, request.sensor, direction_B, biases), direction_B, wish);
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
    return {"in_contact", "touched", "too_far", "error", "sunk", "path_ended"};
  }
  [[nodiscard]] bool needs_plan() const override { return true; }
  [[nodiscard]] command::Contribution add_to(command::FragmentWriter&, const command::ActuatorModel&) const override {
    return {};
  }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const command::ActuatorModel&,
                                                                const command::Places& q_start) const override {
    const auto prepared = prepare_press(request_, cell_at(cell_, q_start), q_start.at(request_.arm));
    if (!prepared) return std::unexpected(prepared.error());
    return press_of(request_, *prepared, cell_, biases_).shared_model();
  }

 private:
  const ForceRequest& request_;
  const command::Cell& cell_;
  command::Biases biases_;
};

class ForceCommand final : public CommandRequest {
 public:
  ForceRequest request;

  [[nodiscard]] MadeCommand make(const Making& making, const std::string& key) const override {
    const command::Actuator actuator = command::arm(making.cell, request.arm);
    const command::Action action = action_of(making);
    command::RuntimeCommand pressed(name, actuator, action);
    MadeCommand made{.command = pressed, .action = action, .actuator = actuator};
    const command::FrameSensor tool = command::tool_pose(making.cell, request.arm);
    const auto ends = [&](const char* what, const State& state, const char* place) {
      pressed.on_entered(state, cancel(pressed));
      pressed.capture(key + what, tool, state);
      made.handler_places.emplace_back(place);
    };
    ends(" too far", action.state("too_far"), "/travel_m");
    ends(" silent", action.state("error"), "/sensor");
    if (request.hold) ends(" held", action.state("in_contact").held_for(*request.hold), "/seconds");
    if (request.drop) ends(" found", action.state("sunk"), "/drop_m");
    if (request.pattern) ends(" path ended", action.state("path_ended"), "/pattern");
    if (request.until) ends(" until", command::state_of(*request.until, making.cell, making.biases), "/until");
    pressed.capture(key + " touched", tool, action.state("touched"));
    pressed.capture(key + " end", tool, pressed.cancelled());
    return made;
  }

  void rehearse(Rehearsal& rehearsal, Findings&) const override {
    rehearsal.touched[request.arm] = true;
    rehearsal.duration += request.hold.value_or(0.0);
  }

  void finish(const EndedTree& ended, const std::string& key, bool cancelled, Context& context,
              Findings& findings) const override {
    const auto was = [&](const char* what) { return ended.value<net::Frame>(key + what).has_value(); };
    const bool touched = was(" touched");
    // Where the tool stood when it was to press no more, else where it touched, is the touch of this arm.
    const auto end = ended.value<net::Frame>(key + " end");
    const auto X_BT = end ? end : ended.value<net::Frame>(key + " touched");
    if (touched && X_BT) findings.append(note_touch(context, request.arm, *X_BT), pointer);
    if (cancelled || was(" held") || was(" found") || was(" until")) return;
    if (was(" silent")) {
      findings.error(pointer + "/sensor", fmt::format("'{}' did not answer, so the arm stopped", request.sensor),
                     "its power and its wires");
    } else if (was(" too far")) {
      findings.error(pointer + "/travel_m", touched ? "the travel was used up after the touch" : "nothing was touched",
                     "a longer travel, another beginning or direction");
    } else if (was(" path ended") && request.must_find) {
      findings.error(pointer, "the pattern has come to its end and nothing was found",
                     "a larger radius, a smaller pitch, or \"on_end\": \"continue\"");
    }
  }

 private:
  [[nodiscard]] command::Action action_of(const Making& making) const {
    if (!request.needs_place()) {
      const auto prepared = prepare_press(request, making.cell, making.cell.arms.find(request.arm)->second.start);
      if (prepared) return press_of(request, *prepared, making.cell, making.biases);
    }
    return command::Action(std::make_shared<const PlacedPress>(request, making.cell, making.biases));
  }
};

}  // namespace

std::unique_ptr<CommandRequest> read_press_command(const Json& json, const std::string& pointer,
                                                   const command::Cell& cell, Findings& findings) {
  auto command = std::make_unique<ForceCommand>();
  ObjectReader reader(json, pointer, findings);
  command->request = read_press(reader, cell, std::nullopt);
  reader.finish();
  return command;
}

std::unique_ptr<CommandRequest> read_search_command(const Json& json, const std::string& pointer,
                                                    const command::Cell& cell, Findings& findings) {
  auto command = std::make_unique<ForceCommand>();
  ObjectReader reader(json, pointer, findings);
  command->request = read_search(reader, cell);
  reader.finish();
  return command;
}

}  // namespace takt::activity
