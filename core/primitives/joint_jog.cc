// Family "kinematics": joints that go at wanted rates.
#include <algorithm>
#include <optional>

#include "core/device/arm.h"
#include "core/motion/stop_range.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/arm_kinematics.h"
#include "core/primitives/rate_follower.h"

namespace takt::primitives {
namespace {

using namespace net;
using kinematics::JointVector;
using kinematics::Vector6;

class JointJog final : public Primitive {
 public:
  explicit JointJog(Setup& setup)
      : rates_(setup.in<JointArray>(
            "rates", {.unit = "rad/s", .doc = "desired rate of each joint", .on_null = OnNull::kHandled})),
        q_(setup.out<JointArray>("q", {.unit = "rad", .doc = "joint positions", .may_be_null = true})),
        dq_(setup.out<JointArray>("dq", {.unit = "rad/s", .doc = "their velocities", .may_be_null = true})),
        ddq_(setup.out<JointArray>("ddq", {.unit = "rad/s^2", .doc = "their accelerations", .may_be_null = true})),
        achieved_(setup.out<Twist>(
            "achieved", {.unit = "m/s,rad/s", .doc = "twist of T now, in the axes of B", .may_be_null = true})),
        kinematics_(setup),
        bounds_{.linear = setup.parameter<Real>("linear_max",
                                                {.unit = "m/s", .doc = "of T", .range = "(0,inf)", .example = "0.25"}),
                .angular = setup.parameter<Real>(
                    "angular_max", {.unit = "rad/s", .doc = "of T", .range = "(0,inf)", .example = "1.0"})} {
    margin_ = setup.parameter<Real>(
        "margin", 0.0, {.unit = "rad", .doc = "kept to the ends of the joints' ranges", .range = "[0,inf)"});
    setup.latency("rates", "dq", {.cycles = 0, .data_dependent = true});
    setup.costs(2500.0);
  }

  Diagnostics prepare() override {
    Diagnostics diagnostics = kinematics_.check();
    if (diagnostics.has_errors() || kinematics_.arm == nullptr) return diagnostics;
    follower_.emplace(kinematics_.arm->description().limits, bounds_);
    stop_time_ = motion::longest_stop(kinematics_.arm->description().limits);
    return diagnostics;
  }

  [[nodiscard]] double stop_time_bound() const override { return stop_time_; }

  void update(const Cycle& cycle) override {
    if (cycle.first) start();
    if (!known_ || !kinematics_.look(follower_->state().q)) return give_up();
    const auto count = follower_->state().q.size();
    const bool stands = cycle.stop_requested || rates_.null() || rates_->size != count;
    const JointVector target = stands ? JointVector(JointVector::Zero(count)) : wanted(cycle.dt);
    if (!follower_->advance(target, cycle.dt, kinematics_)) return give_up();
    const RateFollower::State& state = follower_->state();
    q_.set(JointArray(state.q));
    dq_.set(JointArray(state.dq));
    ddq_.set(JointArray(state.ddq));
    kinematics_.look(state.q);
    const Vector6 V = kinematics_.J_BT * state.dq;
    achieved_.set({.linear = V.head<3>(), .angular = V.tail<3>()});
  }

 private:
  void start() {
    const JointVector& q = kinematics_.arm->set_point().q;
    known_ = q.size() == kinematics_.arm->joint_count();
    if (known_) follower_->start(q, margin_);
  }

  /// Inside the joints' bounds first, then all by one factor, so that the tool keeps its direction.
  [[nodiscard]] JointVector wanted(double dt) const {
    const kinematics::RateBounds bounds = follower_->bounds(dt);
    const JointVector rates = rates_->map().cwiseMax(bounds.lower).cwiseMin(bounds.upper);
    return rates / std::max(1.0, bounds_.share(kinematics_.J_BT * rates));
  }

  void give_up() {
    known_ = false;
    q_.set_null();
    dq_.set_null();
    ddq_.set_null();
    achieved_.set_null();
  }

  In<JointArray> rates_;
  Out<JointArray> q_, dq_, ddq_;
  Out<Twist> achieved_;
  ArmKinematics kinematics_;
  ToolBounds bounds_;
  double margin_ = 0.0;
  std::optional<RateFollower> follower_;
  bool known_ = false;
  double stop_time_ = 0.0;
};

TAKT_PRIMITIVE(
    JointJog, "kinematics",
    "Joint motion at desired rates, from where the arm is, never beyond the limits of any joint in position, "
    "velocity, acceleration and jerk; rates with which the tool would be faster than allowed are made "
    "smaller, all by one factor, and all joints reach them at the same time. Rates of null, or of a wrong size, count "
    "as 0, and so do any once the net is "
    "to stop: the joints come to rest. In the first cycle it has already run for one period. Null if the arm "
    "has no set point yet.");

}  // namespace
}  // namespace takt::primitives
