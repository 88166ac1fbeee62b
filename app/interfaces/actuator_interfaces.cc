#include "app/interfaces/actuator_interfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/activity/mode_change.h"
#include "core/command/actions/freedrive_action.h"
#include "core/expression/tool_settings.h"
#include "core/operations/command/operation_activity.h"
#include "core/operations/grasp/held_part.h"
#include "core/operations/motion/motion_activity.h"

namespace takt::app {
namespace {

using expression::Cell;
using kinematics::JointVector;

bool has_inverse(const Cell& cell, const std::string& name) {
  const auto arm = cell.arms.find(name);
  return arm != cell.arms.end() && arm->second.device->description().inverse != nullptr;
}

operations::MotionTask task_of(operations::PathKind kind, const std::string& arm,
                               const operations::MotionParameters& parameters) {
  operations::MotionTask task{parameters};
  task.kind = kind;
  task.arm = arm;
  return task;
}

activity::Activity goal_motion(activity::Runtime& runtime, operations::PathKind kind, const std::string& arm,
                               operations::Goal goal, const operations::MotionParameters& parameters,
                               const operations::AvoidanceParameters& avoidance = {}) {
  operations::MotionTask task = task_of(kind, arm, parameters);
  task.goal = std::move(goal);
  task.avoidance = avoidance;
  return planned_motion(runtime, std::move(task));
}

/// A pose of the frame that moves, in the base.
operations::Goal in_base(const std::string& arm, const Eigen::Isometry3d& X_BM) {
  return operations::Goal{operations::Goal::Pose{.in = arm, .X = X_BM}};
}

template <class... Interfaces>
std::vector<InterfaceOffer> offers_of() {
  return {InterfaceOffer{Interfaces::kName, &Interfaces::offered_by}...};
}
/// All that there are, those of takt first.
std::vector<InterfaceOffer>& all_offers() {
  static auto offers = offers_of<MotionInterface, PtpInterface, LinInterface, JointInterface, HoldInterface,
                                 ForceInterface, JogInterface, FollowInterface, ControlModeInterface,
                                 FreedriveInterface, GrippingInterface, ToolChangerInterface, OutputInterface>();
  return offers;
}

bool is_output(const Cell& cell, const std::string& name) {
  return cell.digital_outputs.contains(name) || cell.analog_outputs.contains(name);
}

/// @param actuator  whose diagnostic it is
[[noreturn]] void throw_diagnostic(Code code, const std::string& actuator, std::string message, std::string hint) {
  Diagnostics why;
  why.error(code, pointer_segment(actuator), std::move(message), std::move(hint));
  throw activity::ActivityError(std::move(why));
}

}  // namespace

bool PtpInterface::offered_by(const Cell& cell, const std::string& actuator) { return cell.arms.contains(actuator); }
bool LinInterface::offered_by(const Cell& cell, const std::string& actuator) { return has_inverse(cell, actuator); }
bool MotionInterface::offered_by(const Cell& cell, const std::string& actuator) { return has_inverse(cell, actuator); }
bool HoldInterface::offered_by(const Cell& cell, const std::string& actuator) { return cell.arms.contains(actuator); }
bool JointInterface::offered_by(const Cell& cell, const std::string& actuator) { return cell.arms.contains(actuator); }
bool ForceInterface::offered_by(const Cell& cell, const std::string& actuator) {
  return has_inverse(cell, actuator) &&
         std::ranges::any_of(cell.sensors, [&](const auto& one) { return one.second.arm == actuator; });
}
bool JogInterface::offered_by(const Cell& cell, const std::string& actuator) { return has_inverse(cell, actuator); }
bool FollowInterface::offered_by(const Cell& cell, const std::string& actuator) { return has_inverse(cell, actuator); }
bool ControlModeInterface::offered_by(const Cell& cell, const std::string& actuator) {
  const auto arm = cell.arms.find(actuator);
  return arm != cell.arms.end() && arm->second.device->description().modes.modes.size() > 1;
}
bool FreedriveInterface::offered_by(const Cell& cell, const std::string& actuator) {
  return command::freedrive_kind(cell, actuator) != command::FreedriveKind::kNone;
}
bool GrippingInterface::offered_by(const Cell& cell, const std::string& actuator) {
  return cell.grippers.contains(actuator);
}
bool ToolChangerInterface::offered_by(const Cell& cell, const std::string& actuator) {
  return cell.changers.contains(actuator);
}
bool OutputInterface::offered_by(const Cell& cell, const std::string& actuator) { return is_output(cell, actuator); }

activity::Activity planned_motion(activity::Runtime& runtime, operations::MotionTask task) {
  static constexpr std::array<std::string_view, 5> kNames = {"PTP", "LIN", "CIRC", "spline", "move"};
  const std::string arms = task.follower.empty() ? task.arm : task.arm + "+" + task.follower;
  task.name = fmt::format("{} {}", arms, kNames.at(static_cast<std::size_t>(task.kind)));
  const std::string name = task.name, arm = task.arm;
  auto accepted = operations::motion_parameters(task.kind).accept(std::move(task), runtime.cell());
  if (!accepted) return {runtime, operations::refused_activity(name, arm, std::move(accepted.error()))};
  return {runtime, std::make_shared<const operations::MotionActivity>(name, std::vector{std::move(*accepted)},
                                                                      runtime.biases())};
}

activity::Activity PtpInterface::ptp(const JointVector& q_goal, const operations::MotionParameters& parameters) const {
  return goal_motion(runtime(), operations::PathKind::kPtp, actuator(),
                     operations::Goal{operations::Goal::Joints{q_goal}}, parameters);
}

activity::Activity PtpInterface::ptp(const Eigen::Isometry3d& X_BT,
                                     const operations::MotionParameters& parameters) const {
  return goal_motion(runtime(), operations::PathKind::kPtp, actuator(), in_base(actuator(), X_BT), parameters);
}

activity::Activity PtpInterface::spline(const std::vector<JointVector>& points,
                                        const operations::MotionParameters& parameters) const {
  operations::MotionTask task = task_of(operations::PathKind::kSpline, actuator(), parameters);
  for (const JointVector& q : points) task.through.push_back(operations::Goal{operations::Goal::Joints{q}});
  return planned_motion(runtime(), std::move(task));
}

activity::Activity PtpInterface::move(const JointVector& q_goal, const operations::MotionParameters& parameters,
                                      const operations::AvoidanceParameters& avoidance) const {
  return goal_motion(runtime(), operations::PathKind::kMove, actuator(),
                     operations::Goal{operations::Goal::Joints{q_goal}}, parameters, avoidance);
}

activity::Activity PtpInterface::move(const Eigen::Isometry3d& X_BT, const operations::MotionParameters& parameters,
                                      const operations::AvoidanceParameters& avoidance) const {
  return goal_motion(runtime(), operations::PathKind::kMove, actuator(), in_base(actuator(), X_BT), parameters,
                     avoidance);
}

activity::Activity LinInterface::lin(const Eigen::Isometry3d& X_BT,
                                     const operations::MotionParameters& parameters) const {
  return goal_motion(runtime(), operations::PathKind::kLin, actuator(), in_base(actuator(), X_BT), parameters);
}

activity::Activity LinInterface::lin_by(const Eigen::Vector3d& way_B,
                                        const operations::MotionParameters& parameters) const {
  return goal_motion(runtime(), operations::PathKind::kLin, actuator(),
                     operations::Goal{operations::Goal::Step{.in = actuator(), .translation = way_B}}, parameters);
}

activity::Activity LinInterface::circ(const motion::ArcThrough& arc,
                                      const operations::MotionParameters& parameters) const {
  operations::MotionTask task = task_of(operations::PathKind::kCirc, actuator(), parameters);
  task.goal = in_base(actuator(), arc.X_BM_goal);
  task.via = in_base(actuator(), Eigen::Isometry3d(Eigen::Translation3d(arc.p_via)));
  task.orientation = arc.orientation;
  return planned_motion(runtime(), std::move(task));
}

activity::Activity LinInterface::circ(const motion::ArcAbout& arc,
                                      const operations::MotionParameters& parameters) const {
  operations::MotionTask task = task_of(operations::PathKind::kCirc, actuator(), parameters);
  task.about =
      operations::MotionTask::About{.in = actuator(), .centre = arc.centre, .axis = arc.axis, .angle = arc.angle};
  task.orientation = arc.orientation;
  return planned_motion(runtime(), std::move(task));
}

activity::Activity LinInterface::spline(const std::vector<Eigen::Isometry3d>& poses_BT,
                                        const operations::MotionParameters& parameters) const {
  operations::MotionTask task = task_of(operations::PathKind::kSpline, actuator(), parameters);
  for (const Eigen::Isometry3d& X_BT : poses_BT) task.through.push_back(in_base(actuator(), X_BT));
  return planned_motion(runtime(), std::move(task));
}

activity::Activity FreedriveInterface::freedrive(const operations::FreedriveParameters& parameters) const {
  operations::FreedriveParameters own = parameters;
  own.arm = actuator();
  const auto accepted = operations::freedrive_parameters().accept(own, runtime().cell());
  if (!accepted) return make(operations::refused_activity(actuator() + " freedrive", actuator(), accepted.error()));
  return make(operations::freedrive_activity(*accepted, runtime().cell(), runtime().biases()));
}

// -- Control modes ---------------------------------------------------------------------------------------------------

activity::Activity ControlModeInterface::switch_to(device::ControlMode mode) const {
  return make(activity::mode_activity(actuator(), mode));
}

activity::Activity ControlModeInterface::switch_to(std::string_view mode) const {
  if (const auto known = device::control_mode_of(mode)) return switch_to(*known);
  std::vector<std::string> names;
  for (const device::ControlMode one : modes()) names.emplace_back(name_of(one));
  throw_diagnostic(Code::kUnknownName, actuator(), fmt::format("there is no control mode '{}'", mode),
                   nearest_choice(mode, names));
}

const device::Arm& ControlModeInterface::arm() const { return *runtime().cell().arms.at(actuator()).device; }
device::ControlMode ControlModeInterface::mode() const { return arm().mode(); }
std::vector<device::ControlMode> ControlModeInterface::modes() const { return arm().description().modes.modes; }

void JointInterface::check(int joint) const {
  const auto count = runtime().cell().arms.at(actuator()).device->description().limits.velocity.size();
  if (joint < 0 || joint >= count)
    throw_diagnostic(Code::kOutOfRange, actuator(), fmt::format("'{}' has no joint {}", actuator(), joint),
                     fmt::format("0 to {}", count - 1));
}

activity::Activity JointInterface::move_to(int joint, double q, const operations::MotionParameters& parameters) const {
  check(joint);
  return goal_motion(runtime(), operations::PathKind::kPtp, actuator(),
                     operations::Goal{operations::Goal::OneJoint{.joint = joint, .q = q}}, parameters);
}

activity::Activity JointInterface::move_by(int joint, double by, const operations::MotionParameters& parameters) const {
  check(joint);
  return goal_motion(runtime(), operations::PathKind::kPtp, actuator(),
                     operations::Goal{operations::Goal::OneJoint{joint, by, /*by=*/true}}, parameters);
}

void register_interface(const InterfaceOffer& offer) { all_offers().push_back(offer); }

Actuator::Actuator(activity::Runtime& runtime, std::string name) : runtime_(&runtime), name_(std::move(name)) {
  if (!interfaces().empty()) return;
  const Cell& cell = runtime.cell();
  std::vector<std::string> names;
  const auto add = [&names](const auto& map) {
    for (const auto& [one, device] : map) names.push_back(one);
  };
  add(cell.arms);
  add(cell.grippers);
  add(cell.changers);
  add(cell.digital_outputs);
  add(cell.analog_outputs);
  throw_diagnostic(Code::kUnknownName, name_, fmt::format("the cell has no actuator '{}'", name_),
                   nearest_choice(name_, names));
}

std::vector<std::string> Actuator::interfaces() const {
  std::vector<std::string> names;
  for (const InterfaceOffer& one : all_offers())
    if (one.offered_by(runtime_->cell(), name_)) names.emplace_back(one.name);
  return names;
}

void Actuator::refuse(std::string_view interface) const {
  throw_diagnostic(Code::kUnsupported, name_, fmt::format("'{}' has no {}", name_, interface),
                   fmt::format("it offers {}", fmt::join(interfaces(), ", ")));
}

const expression::MountedArm& Actuator::arm() const {
  const auto found = runtime_->cell().arms.find(name_);
  if (found == runtime_->cell().arms.end())
    throw_diagnostic(Code::kWrongType, name_, fmt::format("'{}' is not an arm", name_), "an arm of the cell");
  return found->second;
}

JointVector Actuator::q() const { return arm().device->set_point().q; }

JointVector Actuator::measured_q() const {
  const device::Arm& device = *arm().device;
  if (!device.has_sample())
    throw_diagnostic(Code::kNotKnownYet, name_, fmt::format("'{}' has not measured yet", name_), "after a cycle");
  return device.sample().q;
}

Eigen::Isometry3d Actuator::measured_tool() const {
  return arm().device->description().chain->forward(measured_q()) * arm().X_FT;
}

JointVector Actuator::home() const { return arm().device->description().home; }

Eigen::Isometry3d Actuator::flange() const { return arm().device->description().chain->forward(q()); }

Eigen::Isometry3d Actuator::above(const std::string& name, double height) const {
  const Eigen::Isometry3d down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()));
  return frame(name) * Eigen::Translation3d(0.0, 0.0, height) * down;
}

void Actuator::carry(double mass) const {
  if (!(mass >= 0.0 && std::isfinite(mass)))
    throw_diagnostic(Code::kOutOfRange, name_, fmt::format("a mass of {:g} kg", mass), "0 or more");
  if (arm().device->held())
    throw_diagnostic(Code::kNotPossibleNow, name_,
                     fmt::format("'{}' is running an activity, and its load can change only between activities", name_),
                     "after their end");
  expression::Cell& cell = runtime_->cell();
  if (const auto mismatch = operations::told_mismatch(cell, name_, mass))
    throw_diagnostic(Code::kPayloadMismatch, name_,
                     fmt::format("what '{}' holds weighs {:g} kg, not {:g} kg", name_, mismatch->known, mismatch->told),
                     "its mass, or no call: takt knows it");
  cell.arms.find(name_)->second.told_mass = mass;
  expression::tell_tool_settings(cell);
}

Eigen::Isometry3d Actuator::tcp(const std::string& tool, const std::string& tcp) const {
  (void)arm();
  const auto found = operations::find_tool(runtime_->cell(), name_, {tool, tcp});
  if (found) return found->X_FT;
  Diagnostics why;
  why.append(found.error(), pointer_segment(name_));
  throw activity::ActivityError(std::move(why));
}

void Actuator::use_tool(const std::string& tool, const std::string& tcp_name) const {
  const operations::ArmTools tools{{name_, {tool, tcp_name}, pointer_segment(name_)}};
  (void)tcp(tool, tcp_name);
  expression::Cell& cell = runtime_->cell();
  if (arm().device->held() && changes_tool(cell, tools))
    throw_diagnostic(Code::kNotPossibleNow, name_,
                     fmt::format("'{}' is running an activity, and its tool can change only between activities", name_),
                     "after their end");
  (void)operations::use_tools(cell, tools);
  expression::tell_tool_settings(cell);
}

Eigen::Isometry3d Actuator::frame(const std::string& name) const {
  const auto X_WB = runtime_->cell().frames.pose(name_), X_WF = runtime_->cell().frames.pose(name);
  for (const auto* X : {&X_WB, &X_WF}) {
    if (*X) continue;
    Diagnostics why;
    why.append(X->error(), pointer_segment(name_));
    throw activity::ActivityError(std::move(why));
  }
  return X_WB->inverse() * *X_WF;
}

}  // namespace takt::app
