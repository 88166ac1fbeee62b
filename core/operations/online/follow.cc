#include "core/operations/online/follow.h"

#include <utility>

#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/expression/moving_frames.h"
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

class FollowCommand final : public OnlineCommand {
 public:
  explicit FollowCommand(FollowParameters parameters) : OnlineCommand(parameters), follow_(std::move(parameters)) {}

 private:
  [[nodiscard]] command::Action action_of(const BuildContext& context) const override {
    using expression::TwistSensor;
    const expression::Cell& cell = context.cell;
    command::TrackingParameters own = tool_limits(follow_);
    const expression::FrameSensor X_BI = expression::pose_between(cell, follow_.in, follow_.arm);
    if (expression::moves(cell.frames, follow_.in, follow_.arm))
      own.target_twist = expression::twist_between(cell, follow_.in, follow_.arm);
    if (!follow_.channel) return command::follow(X_BI, own);
    const auto X_IT = expression::channel<net::Frame>(cell, *follow_.channel);
    const TwistSensor within = expression::rotate(X_BI, expression::channel_twist(cell, *follow_.channel));
    own.target_twist =
        own.target_twist
            ? expression::shift(*own.target_twist, expression::rotate(X_BI, expression::position(X_IT))) + within
            : within;
    return command::follow(X_BI * X_IT, own);
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
