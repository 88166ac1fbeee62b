// Family "device": the canonical arm.
#include <fmt/format.h>

#include "core/device/arm.h"
#include "core/kinematics/chain.h"
#include "core/net/format_text.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;
using device::Arm;

static_assert(kJointCapacity == kinematics::kMaxJoints);

class ArmCommand final : public Primitive {
 public:
  explicit ArmCommand(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions", .on_null = OnNull::kStop})),
        dq_(setup.in<JointArray>("dq", {.unit = "rad/s", .doc = "their velocities", .on_null = OnNull::kStop})),
        ddq_(setup.in<JointArray>("ddq", {.unit = "rad/s^2", .doc = "their accelerations", .on_null = OnNull::kStop})),
        arm_(setup.device<Arm>("device", Arm::kKind, "the arm that is driven")),
        mode_(setup.parameter<Text>("mode", Text("any"),
                                    {.doc = "control mode that is needed; any: as the arm is",
                                     .range = "any|position|joint_impedance|cartesian_impedance"})),
        most_bridged_(setup.bridge_cycles("q")) {
    setup.claims("device", mode_.view() == "any" ? std::string_view{} : mode_.view());
    setup.costs(40.0);
  }

  Diagnostics prepare() override {
    const auto mode = device::control_mode_of(mode_.view());
    Diagnostics diagnostics;
    if (mode && arm_ != nullptr && !arm_->description().modes.has(*mode))
      diagnostics.error(Code::kUnknownName, "/mode",
                        fmt::format("arm '{}' has no mode '{}'", arm_->name(), mode_.view()),
                        arm_->description().modes.list());
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) bridged_ = most_bridged_;  // nothing to extrapolate from yet
    if (q_.null() || dq_.null() || ddq_.null()) return bridge(cycle);
    bridged_ = 0;
    arm_->propose(q_->map(), dq_->map(), ddq_->map());
  }

 private:
  void bridge(const Cycle& cycle) {
    if (bridged_ >= most_bridged_) {
      const Text text = format_text("{}: the set point is null", arm_->name());
      return cycle.signals->fail_with(Cause::Code::kNullInput, text.view(), cycle.index);
    }
    ++bridged_;
    const auto& last = arm_->set_point();
    const double h = cycle.dt;
    arm_->propose(last.q + h * last.dq + 0.5 * h * h * last.ddq, last.dq + h * last.ddq, last.ddq);
  }

  In<JointArray> q_, dq_, ddq_;
  Arm* arm_;
  Text mode_;
  Integer most_bridged_;  ///< declared at `q` for the whole set point; bridged with constant acceleration
  std::int64_t bridged_ = 0;
};

class ArmState final : public Primitive {
 public:
  explicit ArmState(Setup& setup)
      : q_(setup.out<JointArray>("q", {.unit = "rad", .doc = "measured positions", .may_be_null = true})),
        dq_(setup.out<JointArray>("dq", {.unit = "rad/s", .doc = "measured velocities", .may_be_null = true})),
        tau_(setup.out<JointArray>(
            "tau", {.unit = "N*m", .doc = "measured torques; null without torque sensors", .may_be_null = true})),
        sent_q_(setup.out<JointArray>("set_point_q",
                                      {.unit = "rad", .doc = "set point of the last cycle", .may_be_null = true})),
        sent_dq_(setup.out<JointArray>("set_point_dq", {.unit = "rad/s", .doc = "its velocity", .may_be_null = true})),
        ready_(setup.out<Boolean>("ready", {.doc = "the arm accepts set points; never null"})),
        age_(setup.out<Real>("age", {.unit = "s", .doc = "age of the sample", .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "the arm that is read")) {
    setup.costs(40.0);
  }

  void update(const Cycle&) override {
    ready_.set(arm_->ready());
    set(q_, arm_->has_sample(), arm_->sample().q);
    set(dq_, arm_->has_sample(), arm_->sample().dq);
    set(tau_, arm_->has_sample() && arm_->sample().tau.size() > 0, arm_->sample().tau);
    const bool sent = arm_->set_point().q.size() > 0;
    set(sent_q_, sent, arm_->set_point().q);
    set(sent_dq_, sent, arm_->set_point().dq);
    if (arm_->has_sample()) {
      age_.set(to_seconds(arm_->sample_age()));
    } else {
      age_.set_null();
    }
  }

 private:
  static void set(Out<JointArray>& out, bool valid, const kinematics::JointVector& value) {
    if (valid) {
      out.set(JointArray(value));
    } else {
      out.set_null();
    }
  }

  Out<JointArray> q_, dq_, tau_, sent_q_, sent_dq_;
  Out<Boolean> ready_;
  Out<Real> age_;
  Arm* arm_;
};

TAKT_PRIMITIVE(
    ArmCommand, "device",
    "Proposes the set point of this cycle to an arm, which the net then holds alone; the guard decides. Null "
    "at any input fails the net and starts the stop reaction; a net that declares {\"q\": {\"bridge_cycles\": n}} has "
    "n cycles of null bridged "
    "with constant acceleration first.");
TAKT_PRIMITIVE(ArmState, "device",
               "The newest sample of an arm and the set point that was sent last. Null until the first sample and when "
               "the newest is older than the device allows.");

}  // namespace
}  // namespace takt::primitives
