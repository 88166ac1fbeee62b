// Commands that find their set points in the cycle: manual control, following, holding an arm.
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/command_request.h"
#include "core/activity/compliance_request.h"
#include "core/base/object_reader.h"
#include "core/base/read_parts.h"
#include "core/command/condition_state.h"
#include "core/command/device_action.h"
#include "core/command/device_sensors.h"
#include "core/command/frame_sensors.h"
#include "core/command/online_action.h"
#include "core/command/planned_path.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using command::State;

constexpr double kDegree = std::numbers::pi / 180.0;

/// What moves an arm until it is cancelled, or until a time or a condition.
class OnlineCommand : public CommandRequest {
 public:
  std::string of_arm;
  std::optional<double> seconds;
  std::optional<command::Condition> until;
  std::optional<ComplianceRequest> compliance;

  [[nodiscard]] MadeCommand make(const Making& making, const std::string&) const final {
    const command::Actuator actuator = command::arm(making.cell, of_arm);
    command::Action action = action_of(making);
    if (compliance) {
      const auto& chain = *making.cell.arms.find(of_arm)->second.device->description().chain;
      action = with_compliance(action, wish_of(*compliance, chain.joint_count()));
    }
    command::RuntimeCommand moved(name, actuator, action);
    MadeCommand made{.command = moved, .action = action, .actuator = actuator};
    if (compliance) made.places = places_of(*compliance);
    if (seconds) {
      moved.on_entered(moved.started(), cancel(moved), {.delay = *seconds});
      made.handler_places.emplace_back("/seconds");
    }
    if (until) {
      moved.on_entered(command::state_of(*until, making.cell, making.biases), cancel(moved));
      made.handler_places.emplace_back("/until");
    }
    return made;
  }

  /// Where it goes shows in the run: the arm is taken to stay where it is.
  void rehearse(Rehearsal& rehearsal, Findings&) const final { rehearsal.duration += seconds.value_or(0.0); }

 protected:
  [[nodiscard]] virtual command::Action action_of(const Making& making) const = 0;
};

void read_end(ObjectReader& reader, const command::Cell& cell, OnlineCommand& command) {
  (void)reader.text("do");
  (void)read_name(reader, "");
  std::vector<std::string> names;
  for (const auto& [name, arm] : cell.arms) names.push_back(name);
  command.of_arm = reader.choice("arm", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  if (reader.has("seconds")) command.seconds = reader.number("seconds", {}, {.low = 0.0, .high = 3600.0});
  command.compliance = read_compliance(reader);
  command.until = command::read_condition(reader, "until", cell);
}

void read_bounds(ObjectReader& reader, command::FollowWish& bounds) {
  bounds.linear_max = reader.number("linear_max_m_s", bounds.linear_max, {.low = 0.0, .high = 1.0, .low_open = true});
  bounds.angular_max = kDegree * reader.number("angular_max_deg_s", bounds.angular_max / kDegree,
                                               {.low = 0.0, .high = 180.0, .low_open = true});
}

/// A channel of a type, by its name. The type is looked at where channels are known.
std::string read_channel(ObjectReader& reader, const command::Cell& cell, net::ValueType type) {
  std::vector<std::string> names;
  for (const auto& [name, channel] : cell.channels) {
    if (channel == nullptr || channel->description().type == type) names.push_back(name);
  }
  const std::string name = reader.text("channel");
  const auto found = cell.channels.find(name);
  if (found == cell.channels.end()) {
    reader.findings().error(
        reader.at("channel"), fmt::format("there is no channel '{}'", name),
        names.empty() ? fmt::format("the cell has none of type {}", net::name_of(type)) : nearest_choice(name, names));
  } else if (found->second != nullptr && found->second->description().type != type) {
    reader.findings().error(reader.at("channel"),
                            fmt::format("'{}' carries {}", name, net::name_of(found->second->description().type)),
                            fmt::format("a channel of type {}", net::name_of(type)));
  }
  return name;
}

command::FrameTerm pose_in_base(const command::Cell& cell, const std::string& arm, const std::string& frame) {
  return command::pose_between(cell, frame, arm);
}

// -- jog -------------------------------------------------------------------------------------------------------------

class JogCommand final : public OnlineCommand {
 public:
  std::optional<std::string> channel;  ///< Twist; else `velocity`
  net::Twist velocity;
  std::string in;  ///< whose axes
  command::Condition held;
  command::FollowWish bounds;

 private:
  [[nodiscard]] command::Action action_of(const Making& making) const override {
    command::FollowWish own = bounds;
    own.speed = command::override_of(making.cell).speed;
    const State enabled = command::state_of(held, making.cell, making.biases);
    return command::jog(command::rotate(axes(making.cell), wanted(making.cell)), enabled, own);
  }
  [[nodiscard]] command::TwistSensor wanted(const command::Cell& cell) const {
    if (channel) return command::channel<net::Twist>(cell, *channel);
    return command::TwistSensor(command::apply(net::ValueType::kTwist, "ConstantTwist",
                                               {{"value", command::Term<net::Twist>(velocity).operand()}}));
  }
  [[nodiscard]] command::FrameTerm axes(const command::Cell& cell) const {
    if (in == "tcp") return command::commanded_tool_pose(cell, of_arm);
    return pose_in_base(cell, of_arm, in);
  }
};

// -- follow ----------------------------------------------------------------------------------------------------------

class FollowCommand final : public OnlineCommand {
 public:
  std::optional<std::string> channel;  ///< Frame: the tool in `in`
  std::string in;                      ///< without a channel: this frame itself
  command::FollowWish bounds;

 private:
  [[nodiscard]] command::Action action_of(const Making& making) const override {
    command::FollowWish own = bounds;
    own.speed = command::override_of(making.cell).speed;
    const command::FrameSensor frame = command::pose_between(making.cell, in, of_arm);
    if (!channel) return command::follow(frame, own);
    return command::follow(frame * command::channel<net::Frame>(making.cell, *channel), own);
  }
};

class HoldCommand final : public OnlineCommand {
  [[nodiscard]] command::Action action_of(const Making&) const override { return command::hold(); }
};

}  // namespace

std::unique_ptr<CommandRequest> read_hold_command(const Json& json, const std::string& pointer,
                                                  const command::Cell& cell, Findings& findings) {
  auto command = std::make_unique<HoldCommand>();
  ObjectReader reader(json, pointer, findings);
  read_end(reader, cell, *command);
  reader.finish();
  return command;
}

std::unique_ptr<CommandRequest> read_jog_command(const Json& json, const std::string& pointer,
                                                 const command::Cell& cell, Findings& findings) {
  auto command = std::make_unique<JogCommand>();
  ObjectReader reader(json, pointer, findings);
  read_end(reader, cell, *command);
  read_bounds(reader, command->bounds);
  command->in = reader.text("in", "world");
  if (reader.has("channel")) {
    command->channel = read_channel(reader, cell, net::ValueType::kTwist);
  } else if (reader.has("linear_m_s") || reader.has("angular_deg_s")) {
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    command->velocity.linear = reader.vector("linear_m_s", zero);
    command->velocity.angular = kDegree * reader.vector("angular_deg_s", zero);
  } else {
    findings.error(pointer, "nothing says how fast", "'channel', 'linear_m_s' or 'angular_deg_s'");
  }
  command->held = command::read_condition(reader, "while", cell, true).value_or(command::Condition());
  reader.finish();
  return command;
}

std::unique_ptr<CommandRequest> read_follow_command(const Json& json, const std::string& pointer,
                                                    const command::Cell& cell, Findings& findings) {
  auto command = std::make_unique<FollowCommand>();
  ObjectReader reader(json, pointer, findings);
  read_end(reader, cell, *command);
  read_bounds(reader, command->bounds);
  if (reader.has("channel")) {
    command->channel = read_channel(reader, cell, net::ValueType::kFrame);
    command->in = reader.text("in", "world");
  } else {
    command->in = reader.text("in");
  }
  reader.finish();
  return command;
}

}  // namespace takt::activity
