#include "serve/jog_net.h"

#include "core/command/actions/joint_jog_action.h"
#include "core/command/single_net.h"
#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"

namespace takt::serve {
namespace {

/// What the channel says, or its age.
expression::ExpressionPtr read_jog(net::ValueType type, const char* primitive, device::Channel* channel,
                                   const char* output) {
  return expression::read_resource(type, primitive, "channel", channel->name(), channel, output, "wanted");
}

command::Action jog_action(const ServedCell& cell, const JogRequest& request, device::Channel* channel,
                           const expression::State& alive) {
  const command::TrackingParameters bounds{.linear_max = request.linear_max, .angular_max = request.angular_max};
  if (request.joints)
    return command::jog(expression::JointsSensor(read_jog(net::ValueType::kJoints, "InputJoints", channel, "value")),
                        alive, bounds);
  const expression::Cell& known = cell.built().cell;
  const expression::TwistSensor wanted(read_jog(net::ValueType::kTwist, "InputTwist", channel, "value"));
  const expression::FrameTerm axes = request.in == "tcp" ? expression::commanded_tool_pose(known, request.arm)
                                                         : expression::pose_between(known, request.in, request.arm);
  return command::jog(expression::rotate(axes, wanted), alive, bounds);
}

}  // namespace

Result<command::MappedCommand> jog_net(const ServedCell& cell, const JogRequest& request) {
  const JogChannels channels = cell.jog_channels(request.arm);
  device::Channel* channel = request.joints ? channels.joints : channels.tool;
  const Nanoseconds period = cell.period();
  const char* primitive = request.joints ? "InputJoints" : "InputTwist";
  const expression::RealSensor age(read_jog(net::ValueType::kReal, primitive, channel, "age"));
  // Half a cycle more, so that it does not depend on the last bit of a time.
  const double allowed = (static_cast<double>(request.timeout_cycles) - 0.5) * to_seconds(period);
  const expression::State silent = expression::is_greater(age, expression::RealTerm(allowed));
  command::RuntimeCommand moved("jog", command::arm(cell.built().cell, request.arm),
                                jog_action(cell, request, channel, !silent));
  moved.on_entered(silent, command::cancel(moved));
  return command::single_net(moved, "jog " + request.arm, period);
}

}  // namespace takt::serve
