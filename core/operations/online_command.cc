// Commands that find their set points in the cycle: manual control, following, holding an arm.
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/command/actions/device_action.h"
#include "core/command/actions/online_action.h"
#include "core/command/actions/planned_path.h"
#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/operations/command_request.h"
#include "core/operations/online_parameters.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using command::State;

/// What moves an arm until it is cancelled, or until a time or a condition.
class OnlineCommand : public CommandRequest {
 public:
  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string&) const final {
    const command::Actuator actuator = command::arm(making.cell, parameters().arm);
    command::Action action = action_of(making);
    if (parameters().compliance) {
      const auto& chain = *making.cell.arms.find(parameters().arm)->second.device->description().chain;
      action = with_compliance(action, wish_of(*parameters().compliance, chain.joint_count()));
    }
    command::RuntimeCommand moved(name, actuator, action);
    MadeCommand made{.command = moved, .action = action, .actuator = actuator};
    if (parameters().compliance) made.places = places_of(*parameters().compliance);
    if (parameters().seconds) {
      moved.on_entered(moved.started(), cancel(moved), {.delay = *parameters().seconds});
      made.handler_places.emplace_back("/seconds");
    }
    if (parameters().until) {
      moved.on_entered(command::state_of(*parameters().until, making.cell, making.biases), cancel(moved));
      made.handler_places.emplace_back("/until");
    }
    return made;
  }

  /// Where it goes shows in the run: the arm is taken to stay where it is.
  void rehearse(Rehearsal& rehearsal, Diagnostics&) const final {
    rehearsal.duration += parameters().seconds.value_or(0.0);
  }

 protected:
  [[nodiscard]] virtual const OnlineParameters& parameters() const = 0;
  [[nodiscard]] virtual command::Action action_of(const BuildContext& making) const = 0;
};

command::FrameTerm pose_in_base(const command::Cell& cell, const std::string& arm, const std::string& frame) {
  return command::pose_between(cell, frame, arm);
}

// -- jog -------------------------------------------------------------------------------------------------------------

class JogCommand final : public OnlineCommand {
 public:
  explicit JogCommand(JogParameters parameters) : jog_(std::move(parameters)) {}

 private:
  [[nodiscard]] const OnlineParameters& parameters() const override { return jog_; }
  [[nodiscard]] command::Action action_of(const BuildContext& making) const override {
    command::FollowWish own = jog_.bounds;
    own.speed = command::override_of(making.cell).speed;
    const State enabled = command::state_of(*jog_.enabled, making.cell, making.biases);
    return command::jog(command::rotate(axes(making.cell), wanted(making.cell)), enabled, own);
  }
  [[nodiscard]] command::TwistSensor wanted(const command::Cell& cell) const {
    if (jog_.channel) return command::channel<net::Twist>(cell, *jog_.channel);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    const net::Twist velocity{.linear = jog_.linear.value_or(none), .angular = jog_.angular.value_or(none)};
    return command::TwistSensor(command::apply(net::ValueType::kTwist, "ConstantTwist",
                                               {{"value", command::Term<net::Twist>(velocity).operand()}}));
  }
  [[nodiscard]] command::FrameTerm axes(const command::Cell& cell) const {
    if (jog_.in == "tcp") return command::commanded_tool_pose(cell, jog_.arm);
    return pose_in_base(cell, jog_.arm, jog_.in);
  }

  JogParameters jog_;
};

// -- follow ----------------------------------------------------------------------------------------------------------

class FollowCommand final : public OnlineCommand {
 public:
  explicit FollowCommand(FollowParameters parameters) : follow_(std::move(parameters)) {}

 private:
  [[nodiscard]] const OnlineParameters& parameters() const override { return follow_; }
  [[nodiscard]] command::Action action_of(const BuildContext& making) const override {
    command::FollowWish own = follow_.bounds;
    own.speed = command::override_of(making.cell).speed;
    const command::FrameSensor frame = command::pose_between(making.cell, follow_.in, follow_.arm);
    if (!follow_.channel) return command::follow(frame, own);
    return command::follow(frame * command::channel<net::Frame>(making.cell, *follow_.channel), own);
  }

  FollowParameters follow_;
};

class HoldCommand final : public OnlineCommand {
 public:
  explicit HoldCommand(OnlineParameters parameters) : hold_(std::move(parameters)) {}

 private:
  [[nodiscard]] const OnlineParameters& parameters() const override { return hold_; }
  [[nodiscard]] command::Action action_of(const BuildContext&) const override { return command::hold(); }

  OnlineParameters hold_;
};

}  // namespace

std::unique_ptr<CommandRequest> read_hold_command(const Json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<HoldCommand>(hold_parameters().read(reader, cell));
}

std::unique_ptr<CommandRequest> read_jog_command(const Json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  JogParameters parameters = jog_parameters().read(reader, cell);
  // With a diagnostic: such a program never runs.
  if (!parameters.enabled) parameters.enabled.emplace();
  return std::make_unique<JogCommand>(std::move(parameters));
}

std::unique_ptr<CommandRequest> read_follow_command(const Json& json, const std::string& pointer,
                                                    const command::Cell& cell, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<FollowCommand>(follow_parameters().read(reader, cell));
}

}  // namespace takt::activity
