#include "core/operations/online/follow.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/operations/command/command_step.h"

namespace takt::operations {
namespace {

void check_follow(FollowParameters& follow, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  if (follow.channel) {
    check_channel(*follow.channel, net::ValueType::kFrame, from);
    if (follow.in.empty()) follow.in = "world";
  } else if (follow.in.empty()) {
    reader.diagnostics().error(Code::kMissing, reader.at("in"), "nothing to follow is given",
                               "Give 'in' (a frame) or 'channel'");
  }
}

/// Something outside says where the frame is, such as the encoder of a belt: it moves by itself, and the tool with it.
bool rides_on_channel(const expression::Cell& cell, const std::string& frame) {
  return std::ranges::any_of(cell.frames.path_to_world(frame), [&](std::string_view name) {
    return cell.frames.relation(name)->kind == world::Relation::Kind::kChannel;
  });
}

class FollowCommand final : public OnlineCommand {
 public:
  explicit FollowCommand(FollowParameters parameters) : OnlineCommand(parameters), follow_(std::move(parameters)) {}

 private:
  [[nodiscard]] command::Action action_of(const BuildContext& context) const override {
    const command::TrackingParameters own = tool_limits(follow_);
    const expression::FrameSensor frame = expression::pose_between(context.cell, follow_.in, follow_.arm);
    const expression::FrameSensor target =
        follow_.channel ? frame * expression::channel<net::Frame>(context.cell, *follow_.channel) : frame;
    if (!rides_on_channel(context.cell, follow_.in)) return command::follow(target, own);
    const expression::TwistSensor twist = expression::twist_between(context.cell, follow_.in, follow_.arm);
    if (!follow_.channel) return command::follow(target, own, twist);
    return command::follow(target, own,
                           expression::shift(twist, expression::position(target) - expression::position(frame)));
  }

  FollowParameters follow_;
};

}  // namespace

const ParameterTable<FollowParameters>& follow_parameters() {
  static const auto table = [] {
    auto follow = online_parameters<FollowParameters>();
    add_tool_limits(follow);
    follow.text("channel", &FollowParameters::channel, "Channel of type Frame: the pose of the tool in 'in'.")
        .text("in", &FollowParameters::in, "Frame that the tool follows; with a channel the frame of its poses.")
        .rule(check_follow);
    return follow;
  }();
  return table;
}

std::unique_ptr<OperationCommand> follow_command(const FollowParameters& parameters) {
  return std::make_unique<FollowCommand>(parameters);
}

Operation follow_operation() {
  return {.name = "follow",
          .doc = "The tool follows a moving frame, or the poses of a channel.",
          .parameters = rows_of<follow_parameters>,
          .read_step = step_of_command,
          .read_command = read_command<FollowCommand, follow_parameters>};
}

}  // namespace takt::operations
