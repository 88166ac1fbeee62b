// Family "kinematics": velocities and forces between joints and frames of an arm.
#include <algorithm>
#include <optional>

#include "core/device/arm.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/differential.h"
#include "core/motion/stop_range.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/arm_kinematics.h"
#include "core/primitives/rate_follower.h"

namespace takt::primitives {
namespace {

using namespace net;
using kinematics::Jacobian;
using kinematics::JointVector;
using kinematics::Vector6;

class JointTorques final : public Primitive {
 public:
  explicit JointTorques(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions"})),
        wrench_(setup.in<Wrench>("wrench", {.unit = "N,N*m", .doc = "at the origin of T, in the axes of the base B"})),
        tau_(setup.out<JointArray>(
            "tau", {.unit = "N*m", .doc = "torques that exert this wrench on the surroundings", .may_be_null = true})),
        kinematics_(setup) {}

  Diagnostics prepare() override { return kinematics_.check(); }

  void update(const Cycle&) override {
    if (wrench_.null() || !kinematics_.look(q_)) return tau_.set_null();
    Vector6 w;
    w << wrench_->force, wrench_->torque;
    tau_.set(JointArray(JointVector(kinematics_.J_BT.transpose() * w)));
  }

 private:
  In<JointArray> q_;
  In<Wrench> wrench_;
  Out<JointArray> tau_;
  ArmKinematics kinematics_;
};

class JointTwist final : public Primitive {
 public:
  explicit JointTwist(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions"})),
        dq_(setup.in<JointArray>("dq", {.unit = "rad/s", .doc = "joint velocities"})),
        twist_(setup.out<Twist>(
            "twist", {.unit = "m/s,rad/s", .doc = "of T at its origin, in the axes of B", .may_be_null = true})),
        kinematics_(setup) {}

  Diagnostics prepare() override { return kinematics_.check(); }

  void update(const Cycle&) override {
    if (dq_.null() || !kinematics_.look(q_) || dq_->size != q_->size) return twist_.set_null();
    const Vector6 V = kinematics_.J_BT * dq_->map();
    twist_.set({.linear = V.head<3>(), .angular = V.tail<3>()});
  }

 private:
  In<JointArray> q_, dq_;
  Out<Twist> twist_;
  ArmKinematics kinematics_;
};

class Manipulability final : public Primitive {
 public:
  explicit Manipulability(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions"})),
        value_(setup.out<Real>("value", {.unit = "1", .doc = "product of the singular values", .may_be_null = true})),
        smallest_(setup.out<Real>("smallest",
                                  {.unit = "1", .doc = "smallest singular value; 0 = singular", .may_be_null = true})),
        condition_(setup.out<Real>("condition", {.unit = "1", .doc = "smallest over largest", .may_be_null = true})),
        kinematics_(setup),
        length_(length_parameter(setup)) {}

  Diagnostics prepare() override { return kinematics_.check(); }

  void update(const Cycle&) override {
    if (!kinematics_.look(q_)) {
      value_.set_null();
      smallest_.set_null();
      return condition_.set_null();
    }
    const kinematics::Dexterity dexterity = kinematics::dexterity(kinematics_.J_BT, length_);
    value_.set(dexterity.manipulability);
    smallest_.set(dexterity.smallest);
    condition_.set(dexterity.condition);
  }

 private:
  In<JointArray> q_;
  Out<Real> value_, smallest_, condition_;
  ArmKinematics kinematics_;
  double length_;
};

/// Each cycle the twist becomes rates of the joints, and they are followed (RateFollower).
class DifferentialInverseKinematics final : public Primitive {
 public:
  explicit DifferentialInverseKinematics(Setup& setup)
      : twist_(setup.in<Twist>("twist", {.unit = "m/s,rad/s",
                                         .doc = "desired twist of T at its origin, in the axes of B",
                                         .on_null = OnNull::kHandled})),
        q_(setup.out<JointArray>("q", {.unit = "rad", .doc = "joint positions", .may_be_null = true})),
        dq_(setup.out<JointArray>("dq", {.unit = "rad/s", .doc = "their velocities", .may_be_null = true})),
        ddq_(setup.out<JointArray>("ddq", {.unit = "rad/s^2", .doc = "their accelerations", .may_be_null = true})),
        achieved_(setup.out<Twist>("achieved", {.unit = "m/s,rad/s", .doc = "twist of T now", .may_be_null = true})),
        smallest_(setup.out<Real>("smallest",
                                  {.unit = "1", .doc = "smallest singular value; 0 = singular", .may_be_null = true})),
        kinematics_(setup),
        length_(length_parameter(setup)),
        damped_below_(setup.parameter<Real>(
            "damped_below", 0.05,
            {.unit = "1", .doc = "smallest singular value below which rates are damped", .range = "(0,1]"})),
        seed_(setup.parameter<JointArray>(
            "seed", JointArray(), {.unit = "rad", .doc = "where it begins; default: the set point of the arm"})),
        bounds_(bounds(
            setup.parameter<Real>("linear_max", 0.0, {.unit = "m/s", .doc = "of T; 0: no bound", .range = "[0,inf)"}),
            setup.parameter<Real>("angular_max", 0.0,
                                  {.unit = "rad/s", .doc = "of T; 0: no bound", .range = "[0,inf)"}))) {
    setup.latency("twist", "dq", {.cycles = 0, .data_dependent = true});
  }

  Diagnostics prepare() override {
    Diagnostics diagnostics = kinematics_.check();
    if (diagnostics.has_errors() || kinematics_.arm == nullptr) return diagnostics;
    const int n = kinematics_.arm->joint_count();
    if (seed_.size != 0 && seed_.size != n)
      diagnostics.error(Code::kWrongSize, "/seed", "wrong number of joints", "Give one number per joint of the arm");
    follower_.emplace(kinematics_.arm->description().limits, bounds_);
    stop_time_ = motion::longest_stop(kinematics_.arm->description().limits);
    return diagnostics;
  }

  [[nodiscard]] double stop_time_bound() const override { return stop_time_; }

  void update(const Cycle& cycle) override {
    if (cycle.first) start();
    const JointVector& q = follower_->state().q;
    if (!known_ || !kinematics_.look(q)) return give_up();
    const JointVector target = cycle.stop_requested ? JointVector(JointVector::Zero(q.size())) : wanted(q, cycle.dt);
    if (!follower_->advance(target, cycle.dt, kinematics_)) return give_up();
    const RateFollower::State& state = follower_->state();
    q_.set(JointArray(state.q));
    dq_.set(JointArray(state.dq));
    ddq_.set(JointArray(state.ddq));
    kinematics_.look(state.q);
    const Vector6 V = kinematics_.J_BT * state.dq;
    achieved_.set({.linear = V.head<3>(), .angular = V.tail<3>()});
    smallest_.set(kinematics::dexterity(kinematics_.J_BT, length_).smallest);
  }

 private:
  static ToolBounds bounds(double linear, double angular) {
    ToolBounds bounds;
    if (linear > 0.0) bounds.linear = linear;
    if (angular > 0.0) bounds.angular = angular;
    return bounds;
  }

  void start() {
    const JointVector q = seed_.size > 0 ? JointVector(seed_.map()) : kinematics_.arm->set_point().q;
    known_ = q.size() == kinematics_.arm->joint_count();
    if (known_) follower_->start(q);
  }

  /// Null asks for standstill.
  [[nodiscard]] JointVector wanted(const JointVector& q, double dt) const {
    if (twist_.null()) return JointVector::Zero(q.size());
    Vector6 V;
    V << twist_->linear, twist_->angular;
    V /= std::max(1.0, bounds_.share(V));
    return kinematics::bounded_rates(kinematics_.J_BT, V, follower_->bounds(dt), length_, damped_below_);
  }

  void give_up() {
    known_ = false;
    q_.set_null();
    dq_.set_null();
    ddq_.set_null();
    achieved_.set_null();
    smallest_.set_null();
  }

  In<Twist> twist_;
  Out<JointArray> q_, dq_, ddq_;
  Out<Twist> achieved_;
  Out<Real> smallest_;
  ArmKinematics kinematics_;
  double length_, damped_below_;
  JointArray seed_;
  ToolBounds bounds_;
  std::optional<RateFollower> follower_;
  bool known_ = false;
  double stop_time_ = 0.0;
};

TAKT_PRIMITIVE(
    JointTorques, "kinematics",
    "Joint torques for a wrench at the tool (transposed Jacobian); gravity is not in them. Null if the number "
    "of joints is not the arm's. The first cycle is like any other.");
TAKT_PRIMITIVE(
    JointTwist, "kinematics",
    "Velocity of the tool for joint velocities (Jacobian). Null if the number of joints is not the arm's. The "
    "first cycle is like any other.");
TAKT_PRIMITIVE(Manipulability, "kinematics",
               "How well the tool can be moved in all directions, from the singular values of the Jacobian with its "
               "linear rows divided by a length. Null if the number of joints is not the arm's.");
TAKT_PRIMITIVE(
    DifferentialInverseKinematics, "kinematics",
    "Joint motion for a desired twist, from where the arm is: damped near singularities, and never beyond the "
    "limits of any joint in position, velocity, acceleration and jerk. Where these forbid the twist, the motion is the "
    "nearest that they allow; `achieved` reports it. For a tool that is bounded all joints reach new rates "
    "at the same time, so that it nearly stays inside its bounds meanwhile. A twist of null counts as 0, and so does "
    "any once the net is to stop: the joints come to rest. In the first cycle it has already run for one period. Null "
    "if the arm has no set point yet.");

}  // namespace
}  // namespace takt::primitives
