#include "core/operations/online/jog.h"

#include <utility>

#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/operations/command/command_step.h"

namespace takt::operations {
namespace {

void check_jog(JogParameters& jog, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const bool velocity = jog.linear || jog.angular;
  if (jog.channel) check_channel(*jog.channel, net::ValueType::kTwist, from);
  if (jog.channel && velocity) {
    reader.diagnostics().error(Code::kConflict, reader.at(jog.linear ? "linear_m_s" : "angular_deg_s"),
                               "a velocity from a channel and a fixed one", "Remove one of them");
  }
  if (!jog.channel && !velocity) {
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "no velocity is given",
                               "Give 'channel', 'linear_m_s' or 'angular_deg_s'");
  }
}

class JogCommand final : public OnlineCommand {
 public:
  explicit JogCommand(JogParameters parameters) : OnlineCommand(parameters), jog_(std::move(parameters)) {
    if (!jog_.enabled) jog_.enabled.emplace();  // with a diagnostic: such a program never runs
  }

 private:
  [[nodiscard]] command::Action action_of(const BuildContext& context) const override {
    const expression::State enabled = expression::state_of(*jog_.enabled, context.cell, context.biases);
    return command::jog(expression::rotate(axes(context.cell), wanted(context.cell)), enabled, tool_limits(jog_));
  }
  [[nodiscard]] expression::TwistSensor wanted(const expression::Cell& cell) const {
    if (jog_.channel) return expression::channel<net::Twist>(cell, *jog_.channel);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    const net::Twist velocity{.linear = jog_.linear.value_or(none), .angular = jog_.angular.value_or(none)};
    return expression::TwistSensor(expression::apply(net::ValueType::kTwist, "ConstantTwist",
                                                     {{"value", expression::Term<net::Twist>(velocity).operand()}}));
  }
  [[nodiscard]] expression::FrameTerm axes(const expression::Cell& cell) const {
    if (jog_.in == "tcp") return expression::commanded_tool_pose(cell, jog_.arm);
    return expression::pose_between(cell, jog_.in, jog_.arm);
  }

  JogParameters jog_;
};

}  // namespace

const ParameterTable<JogParameters>& jog_parameters() {
  static const auto table = [] {
    auto jog = online_parameters<JogParameters>();
    add_tool_limits(jog);
    jog.text("in", &JogParameters::in, "Frame along whose axes the velocity is; \"tcp\": those of the tool.")
        .text("channel", &JogParameters::channel, "Channel of type Twist that gives the velocity.")
        .vector("linear_m_s", "m/s", &JogParameters::linear, "Velocity of the tool centre point.")
        .vector("angular_deg_s", "deg/s", &JogParameters::angular, "Angular velocity of the tool.")
        .condition("while", &JogParameters::enabled, "Dead-man switch: the arm moves only while this is true.")
        .required()
        .rule(check_jog);
    return jog;
  }();
  return table;
}

std::unique_ptr<OperationCommand> jog_command(const JogParameters& parameters) {
  return std::make_unique<JogCommand>(parameters);
}

Operation jog_operation() {
  return {.name = "jog",
          .doc = "Manual control with a dead-man switch.",
          .parameters = rows_of<jog_parameters>,
          .read_step = step_of_command,
          .read_command = read_command<JogCommand, jog_parameters>};
}

}  // namespace takt::operations
