#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/activity/activity.h"
#include "core/activity/command_activity.h"
#include "core/operations/basic/set.h"
#include "core/operations/command/operation_activity.h"
#include "core/operations/force/press.h"
#include "core/operations/force/search.h"
#include "core/operations/grasp/couple.h"
#include "core/operations/grasp/grip.h"
#include "core/operations/motion/motion.h"
#include "core/operations/online/follow.h"
#include "core/operations/online/freedrive.h"
#include "core/operations/online/hold.h"
#include "core/operations/online/jog.h"

/// Operations in C++: what the actuators of a cell offer to programs, groups of activities that belong together
/// (docs/activity-layer.md, docs/operations.md). They take the very parameters that files fill; what is wrong with them
/// is told as to a file when the activity is carried out. Poses are of the arm's tool centre point T in its base B, in
/// m. Realtime: setup.
namespace takt::app {

/// A group of activities of one actuator.
class ActuatorInterface {
 public:
  ActuatorInterface(activity::Runtime& runtime, std::string actuator)
      : runtime_(&runtime), actuator_(std::move(actuator)) {}
  [[nodiscard]] const std::string& actuator() const { return actuator_; }

 protected:
  [[nodiscard]] activity::Runtime& runtime() const { return *runtime_; }
  [[nodiscard]] activity::Activity make(activity::ActivityPtr model) const { return {*runtime_, std::move(model)}; }
  /// An operation of this actuator by its parameters.
  template <class P>
  [[nodiscard]] activity::Activity perform(const P& parameters) const {
    return make(operations::operation_activity(parameters, actuator_, runtime_->context()));
  }

 private:
  activity::Runtime* runtime_;
  std::string actuator_;
};

/// A motion as files have it, with the checks of its table. Its name follows from its arm and its kind.
[[nodiscard]] activity::Activity planned_motion(activity::Runtime& runtime, operations::MotionTask task);

/// Motions in joints, of arms.
class PtpInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "PtpInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  [[nodiscard]] activity::Activity ptp(const kinematics::JointVector& q_goal,
                                       const operations::MotionParameters& parameters = {}) const;
  /// To the nearest configuration that has this pose.
  [[nodiscard]] activity::Activity ptp(const Eigen::Isometry3d& X_BT,
                                       const operations::MotionParameters& parameters = {}) const;
  [[nodiscard]] activity::Activity spline(const std::vector<kinematics::JointVector>& points,
                                          const operations::MotionParameters& parameters = {}) const;
  /// On a path around what is in the way (docs/planning.md), which is looked for right before it begins.
  [[nodiscard]] activity::Activity move(const kinematics::JointVector& q_goal,
                                        const operations::MotionParameters& parameters = {},
                                        const operations::AvoidanceParameters& avoidance = {}) const;
  /// To any configuration that has this pose.
  [[nodiscard]] activity::Activity move(const Eigen::Isometry3d& X_BT,
                                        const operations::MotionParameters& parameters = {},
                                        const operations::AvoidanceParameters& avoidance = {}) const;
};

/// Motions of the tool, of arms with inverse kinematics.
class LinInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "LinInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  [[nodiscard]] activity::Activity lin(const Eigen::Isometry3d& X_BT,
                                       const operations::MotionParameters& parameters = {}) const;
  /// From wherever it will be, by this much in the axes of the base.
  [[nodiscard]] activity::Activity lin_by(const Eigen::Vector3d& way_B,
                                          const operations::MotionParameters& parameters = {}) const;
  [[nodiscard]] activity::Activity circ(const motion::ArcThrough& arc,
                                        const operations::MotionParameters& parameters = {}) const;
  [[nodiscard]] activity::Activity circ(const motion::ArcAbout& arc,
                                        const operations::MotionParameters& parameters = {}) const;
  [[nodiscard]] activity::Activity spline(const std::vector<Eigen::Isometry3d>& poses_BT,
                                          const operations::MotionParameters& parameters = {}) const;
};

/// All motions of an arm.
class MotionInterface final : public PtpInterface, public LinInterface {
 public:
  static constexpr std::string_view kName = "MotionInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  MotionInterface(activity::Runtime& runtime, const std::string& actuator)
      : PtpInterface(runtime, actuator), LinInterface(runtime, actuator) {}
  using LinInterface::spline;
  using PtpInterface::spline;
};

/// Standing still with a living command, of arms.
class HoldInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "HoldInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// Until it is cancelled, or for so long (s).
  [[nodiscard]] activity::Activity hold(std::optional<double> seconds = {}) const { return hold({.seconds = seconds}); }
  [[nodiscard]] activity::Activity hold(const operations::HoldParameters& parameters) const {
    return perform(parameters);
  }
};

/// How an arm follows its set points (docs/control-modes.md), of arms with more than one control mode.
class ControlModeInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "ControlModeInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// Waits until the arm rests and nothing holds it, and brings it into the mode; what follows is planned from there.
  /// Out of impedance, `position` begins where the arm is. A mode that it has not, or cannot go into from the one it is
  /// in, is refused with those that are allowed.
  [[nodiscard]] activity::Activity switch_to(device::ControlMode mode) const;
  [[nodiscard]] activity::Activity switch_to(std::string_view mode) const;
  /// In which it is now.
  [[nodiscard]] device::ControlMode mode() const;
  [[nodiscard]] std::vector<device::ControlMode> modes() const;

 private:
  [[nodiscard]] const device::Arm& arm() const;
};

/// Motions that a force leads, of arms with inverse kinematics and a force/torque sensor of their own.
class ForceInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "ForceInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// Approaches along a direction until contact, then presses with a force: until a time or a state, or until it is
  /// cancelled; then the arm comes to rest.
  [[nodiscard]] activity::Activity press(const operations::PressParameters& parameters = {}) const {
    return perform(parameters);
  }
  /// The same, and follows a pattern across the direction until something is found.
  [[nodiscard]] activity::Activity search(const operations::SearchParameters& parameters) const {
    return perform(parameters);
  }
};

/// Velocities of the tool, of arms with inverse kinematics.
class JogInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "JogInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// Manual control while a dead-man switch is held.
  [[nodiscard]] activity::Activity jog(const operations::JogParameters& parameters) const {
    return perform(parameters);
  }
};

/// Poses that move, of arms with inverse kinematics.
class FollowInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "FollowInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// The tool goes after a frame, or after the poses of a channel.
  [[nodiscard]] activity::Activity follow(const operations::FollowParameters& parameters) const {
    return perform(parameters);
  }
};

/// Guiding by hand, of arms that have joint impedance, or a force/torque sensor and inverse kinematics.
class FreedriveInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "FreedriveInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// A person leads the arm until the end, or until it is cancelled; then it rests where it is, in the control mode
  /// that it had before (command::freedrive). An arm whose force/torque sensor was not tared tares it at the beginning.
  [[nodiscard]] activity::Activity freedrive(const operations::FreedriveParameters& parameters = {}) const;
};

/// Of grippers.
class GrippingInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "GrippingInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// The run fails where what was expected is not between the fingers. With `part` its frame goes with the arm until
  /// the gripper opens, with `part_mass` the arm is set to carry it.
  [[nodiscard]] activity::Activity close(const operations::GripParameters& parameters = {}) const {
    return perform(parameters);
  }
  [[nodiscard]] activity::Activity open(const operations::ReleaseParameters& parameters = {}) const {
    return perform(parameters);
  }
};

/// Of tool changers.
class ToolChangerInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "ToolChangerInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// The run fails where no tool side is, or another one than was named. What is coupled is a tool of the arm from then
  /// on: Actuator::use_tool().
  [[nodiscard]] activity::Activity couple(const operations::CoupleParameters& parameters = {}) const {
    return perform(parameters);
  }
  [[nodiscard]] activity::Activity uncouple(const operations::UncoupleParameters& parameters = {}) const {
    return perform(parameters);
  }
};

/// Of digital and analog outputs.
class OutputInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "OutputInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  [[nodiscard]] activity::Activity set(bool value) const { return set(operations::SetParameters{.value = value}); }
  [[nodiscard]] activity::Activity set(double value) const { return set(operations::SetParameters{.value = value}); }
  /// As a file has it: a value, or what an analog output follows.
  [[nodiscard]] activity::Activity set(const operations::SetParameters& parameters) const {
    return perform(parameters);
  }
};

/// One joint of an arm; the others rest.
class JointInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "JointInterface";
  [[nodiscard]] static bool offered_by(const expression::Cell& cell, const std::string& actuator);
  using ActuatorInterface::ActuatorInterface;

  /// @param joint  from 0. Throws ActivityError if there is none. @param q  rad, or m of a sliding joint
  [[nodiscard]] activity::Activity move_to(int joint, double q,
                                           const operations::MotionParameters& parameters = {}) const;
  /// From wherever it will be, by so much.
  [[nodiscard]] activity::Activity move_by(int joint, double by,
                                           const operations::MotionParameters& parameters = {}) const;

 private:
  void check(int joint) const;
};

/// An interface as Actuator::interfaces() lists it.
struct InterfaceOffer {
  std::string_view name;
  bool (*offered_by)(const expression::Cell& cell, const std::string& actuator);
};
void register_interface(const InterfaceOffer& offer);
/// Lists an interface of a project or a plug-in with those that takt brings: `const RegisterInterface<Weld> kWeld;` at
/// the outermost level of its file. `use<Weld>()` needs no registration. Interface: kName and offered_by() as those
/// above. Thread: one at a time, before programs run.
template <class Interface>
class RegisterInterface {
 public:
  RegisterInterface() { register_interface({Interface::kName, &Interface::offered_by}); }
};

/// Something of the cell that can be commanded, as programs see it: arm.use<LinInterface>().lin(goal). A cheap
/// value.
class Actuator {
 public:
  /// Throws ActivityError, with the nearest name, if the cell has nothing of this name.
  Actuator(activity::Runtime& runtime, std::string name);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] activity::Runtime& runtime() const { return *runtime_; }
  /// Throws ActivityError, with what it offers, if it has no such interface.
  template <class Interface>
  [[nodiscard]] Interface use() const {
    if (!offers<Interface>()) refuse(Interface::kName);
    return Interface(*runtime_, name_);
  }
  template <class Interface>
  [[nodiscard]] bool offers() const {
    return Interface::offered_by(runtime_->cell(), name_);
  }
  /// Any operation that is a command, by its parameters; also of a plug-in: robot.perform(PressParameters{.force = 5}).
  template <class P>
  [[nodiscard]] activity::Activity perform(P parameters) const {
    return {*runtime_, operations::operation_activity(std::move(parameters), name_, runtime_->context())};
  }
  /// Names of the interfaces that it offers.
  [[nodiscard]] std::vector<std::string> interfaces() const;

  // Of arms.
  /// The set point of now.
  [[nodiscard]] kinematics::JointVector q() const;
  /// What its controller measured last, rad or m. Throws ActivityError before its first sample.
  [[nodiscard]] kinematics::JointVector measured_q() const;
  /// The posture of its model's device file.
  [[nodiscard]] kinematics::JointVector home() const;
  /// Where flange and tool centre point are by the set point of now, in the base.
  [[nodiscard]] Eigen::Isometry3d flange() const;
  [[nodiscard]] Eigen::Isometry3d tool() const { return flange() * arm().X_FT; }
  /// The tool centre point in the base by measured_q().
  [[nodiscard]] Eigen::Isometry3d measured_tool() const;
  /// A frame of the cell in the base of the arm. Throws ActivityError if it is not there.
  [[nodiscard]] Eigen::Isometry3d frame(const std::string& name) const;
  /// A tool pose in the base that looks down the z axis of a frame, from this height (m) above it.
  [[nodiscard]] Eigen::Isometry3d above(const std::string& name, double height) const;
  /// Sets an arm at rest to carry a further point mass (kg) at its tool centre point; and not to.
  /// Where its grippers hold parts whose masses are known it is a check: throws ActivityError with
  /// Code::kPayloadMismatch.
  void carry(double mass) const;
  void put_down() const { carry(0.0); }
  /// The tool that counts from now on for an arm that stands: its tool centre point, also for its controller. Without a
  /// name the one that the cell declares; `tcp` may be a frame that rides on its flange, of a part that it holds for
  /// instance. Throws ActivityError.
  void use_tool(const std::string& tool = {}, const std::string& tcp = {}) const;
  /// The pose of a tool centre point in the flange, as MotionParameters::X_FM wants it. Throws ActivityError.
  [[nodiscard]] Eigen::Isometry3d tcp(const std::string& tool, const std::string& tcp = {}) const;
  /// Override, pause and resume (Runtime).
  void set_speed(double rate) const { runtime_->set_speed(name_, rate); }
  void pause() const { runtime_->pause(name_); }
  void resume() const { runtime_->resume(name_); }

 private:
  [[noreturn]] void refuse(std::string_view interface) const;
  [[nodiscard]] const expression::MountedArm& arm() const;

  activity::Runtime* runtime_;
  std::string name_;
};

}  // namespace takt::app
