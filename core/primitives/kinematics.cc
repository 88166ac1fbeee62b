// Family "kinematics": between joints and frames of an arm.
#include <fmt/format.h>

#include "core/device/arm.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/link_path.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/arm_kinematics.h"

namespace takt::primitives {
namespace {

using namespace net;
using device::Arm;
using kinematics::IkStatus;
using kinematics::JointVector;
using kinematics::Vector6;

class ForwardKinematics final : public Primitive {
 public:
  explicit ForwardKinematics(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions"})),
        dq_(setup.in<JointArray>("dq", {.unit = "rad/s",
                                        .doc = "joint velocities, for the twist only",
                                        .on_null = OnNull::kHandled,
                                        .optional = true})),
        flange_(setup.out<Frame>("flange", {.unit = "m", .doc = "pose of the flange F in the arm's base B"})),
        frame_(setup.out<Frame>("frame", {.unit = "m", .doc = "pose of T in B"})),
        twist_(setup.out<Twist>(
            "twist", {.unit = "m/s,rad/s", .doc = "velocity of T in B, expressed in B", .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "whose kinematics")),
        X_FT_(tool_parameter(setup, arm_)) {
    setup.costs(400.0);
  }

  Diagnostics prepare() override { return need_chain(arm_, false); }

  void update(const Cycle&) override {
    const auto& chain = *arm_->description().chain;
    if (q_.null() || q_->size != chain.joint_count()) {
      flange_.set_null();
      twist_.set_null();
      return frame_.set_null();
    }
    const JointVector q = q_->map();
    const bool has_rates = !dq_.null() && dq_->size == q_->size;
    if (!has_rates) {
      const Frame X_BF = chain.forward(q);
      twist_.set_null();
      flange_.set(X_BF);
      return frame_.set(X_BF * X_FT_);
    }
    Frame X_BF;
    kinematics::Jacobian J;
    chain.jacobian(q, X_BF, J);
    const JointVector dq = dq_->map();
    const Vector6 V = J * dq;
    const Vector p_FT_B = X_BF.linear() * X_FT_.translation();
    twist_.set({.linear = V.head<3>() + V.tail<3>().cross(p_FT_B), .angular = V.tail<3>()});
    flange_.set(X_BF);
    frame_.set(X_BF * X_FT_);
  }

 private:
  In<JointArray> q_, dq_;
  Out<Frame> flange_, frame_;
  Out<Twist> twist_;
  Arm* arm_;
  Frame X_FT_;
};

class LinkKinematics final : public Primitive {
 public:
  explicit LinkKinematics(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions"})),
        dq_(setup.in<JointArray>("dq", {.unit = "rad/s",
                                        .doc = "joint velocities, for the twist only",
                                        .on_null = OnNull::kHandled,
                                        .optional = true})),
        frame_(setup.out<Frame>("frame", {.unit = "m", .doc = "pose of M in the arm's base B"})),
        twist_(setup.out<Twist>(
            "twist", {.unit = "m/s,rad/s", .doc = "velocity of M in B, expressed in B", .may_be_null = true})),
        arm_(setup.device<Arm>("device", Arm::kKind, "whose link")),
        link_(setup.parameter<std::string>("link", {.doc = "name of the link L in the URDF", .example = R"("link3")"})),
        X_LM_(setup.parameter<Frame>("offset", Frame::Identity(), {.unit = "m", .doc = "pose of the frame M in L"})) {
    setup.costs(400.0);
  }

  Diagnostics prepare() override {
    Diagnostics diagnostics = need_chain(arm_, false);
    if (diagnostics.has_errors() || arm_ == nullptr) return diagnostics;
    const auto& links = arm_->description().links;
    path_ = links == nullptr ? nullptr : links->find(link_);
    if (path_ == nullptr)
      diagnostics.error(Code::kUnknownName, "/link", fmt::format("arm '{}' moves no link '{}'", arm_->name(), link_),
                        links == nullptr ? "Name another arm" : nearest_choice(link_, links->names()));
    return diagnostics;
  }

  void update(const Cycle&) override {
    if (q_.null() || q_->size != arm_->joint_count()) {
      twist_.set_null();
      return frame_.set_null();
    }
    const JointVector q = q_->map();
    if (dq_.null() || dq_->size != q_->size) {
      twist_.set_null();
      return frame_.set(path_->pose(q) * X_LM_);
    }
    const auto& [X_BL, V] = path_->motion(q, dq_->map());
    const Vector p_LM_B = X_BL.linear() * X_LM_.translation();
    twist_.set({.linear = V.head<3>() + V.tail<3>().cross(p_LM_B), .angular = V.tail<3>()});
    frame_.set(X_BL * X_LM_);
  }

 private:
  In<JointArray> q_, dq_;
  Out<Frame> frame_;
  Out<Twist> twist_;
  Arm* arm_;
  std::string link_;
  Frame X_LM_;
  const kinematics::LinkPath* path_ = nullptr;
};

class InverseKinematics final : public Primitive {
 public:
  explicit InverseKinematics(Setup& setup)
      : frame_(setup.in<Frame>("frame", {.unit = "m", .doc = "desired pose of T in the arm's base B"})),
        twist_(setup.in<Twist>("twist", {.unit = "m/s,rad/s", .doc = "its velocity, expressed in B"})),
        acceleration_(setup.in<Twist>("acceleration", {.unit = "m/s^2,rad/s^2", .doc = "its acceleration"})),
        held_(setup.in<JointArray>("held", {.unit = "rad", .doc = "values of the held joints"})),
        held_velocity_(setup.in<JointArray>("held_velocity", {.unit = "rad/s", .doc = "their velocities"})),
        held_acceleration_(
            setup.in<JointArray>("held_acceleration", {.unit = "rad/s^2", .doc = "their accelerations"})),
        q_(setup.out<JointArray>("q", {.unit = "rad", .doc = "joint positions", .may_be_null = true})),
        dq_(setup.out<JointArray>("dq", {.unit = "rad/s", .doc = "their velocities", .may_be_null = true})),
        ddq_(setup.out<JointArray>("ddq", {.unit = "rad/s^2", .doc = "their accelerations", .may_be_null = true})),
        status_(setup.out<Integer>("status", {.doc = "0 solved, 1 not converged, 2 singular; null if an input is"})),
        arm_(setup.device<Arm>("device", Arm::kKind, "whose kinematics")),
        X_FT_(tool_parameter(setup, arm_)),
        seed_(setup.parameter<JointArray>(
            "seed", JointArray(),
            {.unit = "rad", .doc = "where the branch begins; default: the set point of the arm"})) {
    setup.costs(1'500.0);
  }

  Diagnostics prepare() override {
    X_TF_ = X_FT_.inverse();
    Diagnostics diagnostics = need_chain(arm_, true);
    if (diagnostics.has_errors() || arm_ == nullptr) return diagnostics;
    if (seed_.size != 0 && seed_.size != arm_->joint_count())
      diagnostics.error(Code::kWrongSize, "/seed", "wrong number of joints", "Give one number per joint of the arm");
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) start();
    const bool any_null = frame_.null() || twist_.null() || acceleration_.null() || held_.null() ||
                          held_velocity_.null() || held_acceleration_.null();
    if (any_null) {
      status_.set_null();
      return give_up();
    }
    const auto& inverse = *arm_->description().inverse;
    const auto held_count = static_cast<std::int64_t>(inverse.held_joints().size());
    const bool sizes_fit = held_->size == held_count && held_velocity_->size == held_count &&
                           held_acceleration_->size == held_count && state_.q.size() == arm_->joint_count();
    // The solution of the last cycle, moved on by one period, is next to the new one.
    const double h = cycle.dt;
    JointVector q = state_.q + h * state_.dq + 0.5 * h * h * state_.ddq, dq = state_.dq, ddq = state_.ddq;
    const IkStatus status = sizes_fit ? inverse.solve_motion(flange_goal(), q, dq, ddq) : IkStatus::kNotConverged;
    status_.set(static_cast<Integer>(status));
    if (status != IkStatus::kOk) return give_up();
    state_ = {.q = q, .dq = dq, .ddq = ddq};
    q_.set(JointArray(q));
    dq_.set(JointArray(dq));
    ddq_.set(JointArray(ddq));
  }

 private:
  void start() {
    if (seed_.size > 0) {
      state_.q = seed_.map();
    } else {
      state_.q = arm_->set_point().q;
    }
    state_.dq = state_.ddq = JointVector::Zero(state_.q.size());
  }

  /// After a failure the next attempt begins where the last success was, without its motion.
  void give_up() {
    state_.dq.setZero();
    state_.ddq.setZero();
    q_.set_null();
    dq_.set_null();
    ddq_.set_null();
  }

  /// The same motion, told of the flange: both frames belong to one rigid body.
  [[nodiscard]] kinematics::InverseKinematics::Goal flange_goal() const {
    kinematics::InverseKinematics::Goal goal;
    const Vector p_TF_B = frame_->linear() * X_TF_.translation();
    const Vector &w = twist_->angular, &alpha = acceleration_->angular;
    goal.X_BF = *frame_ * X_TF_;
    goal.V_BF_B << twist_->linear + w.cross(p_TF_B), w;
    goal.A_BF_B << acceleration_->linear + alpha.cross(p_TF_B) + w.cross(w.cross(p_TF_B)), alpha;
    goal.held = held_->map();
    goal.held_dq = held_velocity_->map();
    goal.held_ddq = held_acceleration_->map();
    return goal;
  }

  In<Frame> frame_;
  In<Twist> twist_, acceleration_;
  In<JointArray> held_, held_velocity_, held_acceleration_;
  Out<JointArray> q_, dq_, ddq_;
  Out<Integer> status_;
  Arm* arm_;
  Frame X_FT_, X_TF_ = Frame::Identity();
  JointArray seed_;
  struct State {
    JointVector q, dq, ddq;
  } state_;
};

TAKT_PRIMITIVE(ForwardKinematics, "kinematics",
               "Poses of flange and tool for joint positions; their twist if velocities are given. Null if the number "
               "of joints is not the arm's.");
TAKT_PRIMITIVE(
    LinkKinematics, "kinematics",
    "Pose of a frame on a link of an arm for joint positions; its twist if velocities are given. Null if the "
    "number of joints is not the arm's.");
TAKT_PRIMITIVE(InverseKinematics, "kinematics",
               "Joint motion for the motion of a frame, on the branch of the last cycle (first cycle: of the seed). "
               "Null with a status where there is no solution.");

}  // namespace
}  // namespace takt::primitives
