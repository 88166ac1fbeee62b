// Family "device": an arm that gives way, and what it feels.
#include <cmath>

#include <Eigen/Dense>

#include "core/device/arm.h"
#include "core/device/arm_force.h"
#include "core/net/format_text.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/arm_kinematics.h"

namespace takt::primitives {
namespace {

using namespace net;
using device::Arm;
using device::Compliance;
using device::ControlMode;
using kinematics::JointVector;

/// A diagnostic with all that is allowed if the arm has no such mode.
Diagnostics need_mode(const Arm* arm, ControlMode mode, const char* pointer) {
  Diagnostics diagnostics;
  if (arm != nullptr && !arm->description().modes.has(mode))
    diagnostics.error(Code::kUnknownName, pointer, fmt::format("arm '{}' has no mode '{}'", arm->name(), name_of(mode)),
                      arm->description().modes.list());
  return diagnostics;
}

/// The part that both modes of impedance share: where the springs rest, and how what the net wants of them is reached.
class ImpedanceCommand : public Primitive {
 public:
  Diagnostics prepare() override { return need_mode(arm_, mode_, "/device"); }

  void update(const Cycle& cycle) final {
    if (q_.null() || dq_.null() || ddq_.null() || wants_null()) return fail(cycle);
    // In another mode still, where that changes in this cycle: it begins with the standard.
    const auto& impedance = arm_->description().impedance;
    Compliance from = arm_->mode() == mode_ ? arm_->compliance() : impedance.standard(mode_);
    Compliance wanted = impedance.standard(mode_);
    if (!fill(wanted)) return fail(cycle);
    const Compliance next = approach(from, wanted, impedance.range(mode_), arm_->compliance_share());
    settled_.set(next == wanted);
    arm_->propose(q_->map(), dq_->map(), ddq_->map(), next);
  }

 protected:
  ImpedanceCommand(Setup& setup, ControlMode mode)
      : q_(setup.in<JointArray>(
            "q", {.unit = "rad", .doc = "joint positions of the rest position", .on_null = OnNull::kStop})),
        dq_(setup.in<JointArray>("dq", {.unit = "rad/s", .doc = "their velocities", .on_null = OnNull::kStop})),
        ddq_(setup.in<JointArray>("ddq", {.unit = "rad/s^2", .doc = "their accelerations", .on_null = OnNull::kStop})),
        settled_(setup.out<Boolean>(
            "settled", {.doc = "stiffness and the other values have reached the commanded ones", .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "the arm that is driven")),
        mode_(mode) {
    setup.claims("device", name_of(mode));
    setup.costs(120.0);
  }

  /// An input that is fed and null.
  [[nodiscard]] virtual bool wants_null() const = 0;
  /// Puts what the net wants over the standard. @return false for a wrong number of axes.
  [[nodiscard]] virtual bool fill(Compliance& wanted) const = 0;

  template <class T>
  static bool null(const In<T>& in) {
    return in.bound() && in.null();
  }
  /// @return false if the sizes differ.
  static bool put(JointVector& values, const In<JointArray>& in) {
    if (!in.bound()) return true;
    if (in->size != values.size()) return false;
    values = in->map();
    return true;
  }
  static PortSpec optional_value(const char* unit, const char* doc) {
    return {.unit = unit, .doc = doc, .on_null = OnNull::kStop, .optional = true};
  }

 private:
  void fail(const Cycle& cycle) {
    settled_.set_null();
    const Text text =
        format_text("{}: an input of its {} command is null or has a wrong size", arm_->name(), name_of(mode_));
    cycle.signals->fail_with(Cause::Code::kNullInput, text.view(), cycle.index);
  }

  In<JointArray> q_, dq_, ddq_;
  Out<Boolean> settled_;

 protected:
  Arm* arm_;
  ControlMode mode_;
};

class JointImpedanceCommand final : public ImpedanceCommand {
 public:
  explicit JointImpedanceCommand(Setup& setup)
      : ImpedanceCommand(setup, ControlMode::kJointImpedance),
        stiffness_(
            setup.in<JointArray>("stiffness", optional_value("N*m/rad", "of each joint; unlinked: the device's"))),
        damping_ratio_(
            setup.in<JointArray>("damping_ratio", optional_value("1", "of each joint; unlinked: the device's"))),
        torque_(setup.in<JointArray>("torque",
                                     optional_value("N*m", "added to the torque of the stiffness; unlinked: 0"))) {}

 private:
  [[nodiscard]] bool wants_null() const override { return null(stiffness_) || null(damping_ratio_) || null(torque_); }
  [[nodiscard]] bool fill(Compliance& wanted) const override {
    return put(wanted.stiffness, stiffness_) && put(wanted.damping_ratio, damping_ratio_) &&
           put(wanted.feed_forward, torque_);
  }

  In<JointArray> stiffness_, damping_ratio_, torque_;
};

class CartesianImpedanceCommand final : public ImpedanceCommand {
 public:
  explicit CartesianImpedanceCommand(Setup& setup)
      : ImpedanceCommand(setup, ControlMode::kCartesianImpedance),
        stiffness_(setup.in<Vector>("stiffness", optional_value("N/m", "along x, y, z; unlinked: the device's"))),
        rotational_stiffness_(setup.in<Vector>("rotational_stiffness",
                                               optional_value("N*m/rad", "about x, y, z; unlinked: the device's"))),
        damping_ratio_(setup.in<Real>("damping_ratio", optional_value("1", "of all axes; unlinked: the device's"))),
        wrench_(setup.in<Wrench>(
            "wrench", optional_value("N,N*m", "that the tool exerts in addition to the stiffness; unlinked: 0"))),
        nullspace_stiffness_(setup.in<Real>(
            "nullspace_stiffness",
            optional_value("N*m/rad", "towards q in what the tool does not feel; unlinked: the device's"))),
        in_tool_axes_(setup
                          .parameter<Text>("axes", Text("base"),
                                           {.doc = "of stiffness and wrench; they act at the tool centre point",
                                            .range = "base|tool"})
                          .view() == "tool") {}

 private:
  [[nodiscard]] bool wants_null() const override {
    return null(stiffness_) || null(rotational_stiffness_) || null(damping_ratio_) || null(wrench_) ||
           null(nullspace_stiffness_);
  }
  [[nodiscard]] bool fill(Compliance& wanted) const override {
    wanted.in_tool_axes = in_tool_axes_;
    if (stiffness_.bound()) wanted.stiffness.head<3>() = *stiffness_;
    if (rotational_stiffness_.bound()) wanted.stiffness.segment<3>(3) = *rotational_stiffness_;
    if (damping_ratio_.bound()) wanted.damping_ratio.setConstant(*damping_ratio_);
    if (damping_ratio_.bound()) wanted.nullspace_damping_ratio = *damping_ratio_;
    if (nullspace_stiffness_.bound()) wanted.nullspace_stiffness = *nullspace_stiffness_;
    if (!wrench_.bound()) return true;
    wanted.feed_forward.head<3>() = wrench_->force;
    wanted.feed_forward.segment<3>(3) = wrench_->torque;
    return true;
  }

  In<Vector> stiffness_, rotational_stiffness_;
  In<Real> damping_ratio_;
  In<Wrench> wrench_;
  In<Real> nullspace_stiffness_;
  bool in_tool_axes_;
};

class ArmMode final : public Primitive {
 public:
  explicit ArmMode(Setup& setup)
      : mode_(setup.out<Text>("mode", {.doc = "in which set points are followed; never null"})),
        changing_(setup.out<Boolean>("changing", {.doc = "the device is changing into another", .may_be_null = true})),
        braked_(setup.out<Boolean>("braked", {.doc = "the brakes are closed", .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "the arm that is read")) {}

  void update(const Cycle&) override {
    mode_.set(Text(name_of(arm_->mode())));
    if (!arm_->has_sample()) {
      changing_.set_null();
      return braked_.set_null();
    }
    changing_.set(arm_->sample().changing_mode);
    braked_.set(arm_->sample().braked);
  }

 private:
  Out<Text> mode_;
  Out<Boolean> changing_, braked_;
  Arm* arm_;
};

class ExternalTorque final : public Primitive {
 public:
  explicit ExternalTorque(Setup& setup)
      : torque_(setup.out<JointArray>(
            "torque",
            {.unit = "N*m", .doc = "that the surroundings exert; null without an estimate", .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "the arm that is read")) {}

  void update(const Cycle&) override {
    if (!arm_->has_sample() || arm_->sample().tau_external.size() == 0) return torque_.set_null();
    torque_.set(JointArray(arm_->sample().tau_external));
  }

 private:
  Out<JointArray> torque_;
  Arm* arm_;
};

/// The wrench w with J^T w = tau in the sense of least squares: where J has lost a direction, nothing can be said.
class ExternalWrench final : public Primitive {
 public:
  explicit ExternalWrench(Setup& setup)
      : wrench_(setup.out<Wrench>("wrench", {.unit = "N,N*m",
                                             .frame = "F",
                                             .doc = "on the flange, in its frame F; null without an estimate and near "
                                                    "singular postures",
                                             .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "the arm that is read")) {
    setup.costs(1500.0);
  }

  Diagnostics prepare() override { return need_chain(arm_, /*need_inverse=*/false); }

  void update(const Cycle&) override {
    if (!arm_->has_sample() || arm_->sample().tau_external.size() == 0) return wrench_.set_null();
    const auto& sample = arm_->sample();
    const auto wrench = device::external_wrench(*arm_->description().chain, sample.q, sample.tau_external, J_);
    if (!wrench) return wrench_.set_null();
    wrench_.set(*wrench);
  }

 private:
  Out<Wrench> wrench_;
  Arm* arm_;
  kinematics::Jacobian J_;
};

TAKT_PRIMITIVE(JointImpedanceCommand, "device",
               "Proposes the set point of this cycle to an arm whose joints are springs and dampers about it. "
               "Stiffness and the other values change at the rates of the device, from what was sent last; the guard "
               "checks limits. Null at an input that is fed fails the net.");
TAKT_PRIMITIVE(CartesianImpedanceCommand, "device",
               "Proposes the set point of this cycle to an arm whose tool is a spring and a damper about the pose that "
               "belongs to it. Stiffness and the other values change at the rates of the device, from what was sent "
               "last; the guard checks limits. Null at an input that is fed fails the net.");
TAKT_PRIMITIVE(ArmMode, "device", "Control mode and brakes of an arm.");
TAKT_PRIMITIVE(ExternalTorque, "device",
               "What the surroundings exert on the joints of an arm, as the device estimates it. Null until the first "
               "sample, when the newest is too old, and for a device without an estimate.");
TAKT_PRIMITIVE(ExternalWrench, "device",
               "What the surroundings exert on the flange of an arm, in the axes of the flange: from the external "
               "torques and the Jacobian. Null where ExternalTorque is, and near singular postures.");

}  // namespace
}  // namespace takt::primitives
