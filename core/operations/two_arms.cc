#include "core/operations/two_arms.h"

#include <utility>

#include <fmt/format.h>

#include "core/activity/dual_entry_motion.h"
#include "core/operations/operation_activity.h"

namespace takt::activity {
namespace {

using kinematics::JointVector;
using motion::ArmModel;

class TwoArmActivity final : public ActivityModel {
 public:
  TwoArmActivity(const std::string& kind, Grasp grasp, LegOf leg, MotionOptions options)
      : ActivityModel(fmt::format("{}+{} {}", grasp.leader, grasp.follower, kind)),
        grasp_(std::move(grasp)),
        leg_(std::move(leg)),
        options_(std::move(options)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {grasp_.leader, grasp_.follower}; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    Diagnostics wrong;
    check_blend(options_, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    const Predecessor& leads = planning.predecessors.find(grasp_.leader)->second;
    const Predecessor& follows = planning.predecessors.find(grasp_.follower)->second;
    if (!leads.at_end.rests() || !follows.at_end.rests())
      return failure(Code::kUnknownPosition, "",
                     fmt::format("'{}': the end position of the arms is unknown before the run", name()),
                     "a motion after the end of what runs");
    const motion::ArmPair pair = pair_of(planning.cell, grasp_);
    if (Diagnostics apart = check_grasp(pair, *leads.at_end.q, *follows.at_end.q); apart.has_errors())
      return std::unexpected(std::move(apart));
    const std::vector<motion::LegMaker> makers{maker(pair.leader)};
    auto from_rest = motion::plan_pair(pair, *leads.at_end.q, *follows.at_end.q, makers);
    if (!from_rest) return std::unexpected(std::move(from_rest.error()));
    auto prepared = prepare_dual_entry(planning,
                                       {.name = name(),
                                        .grasp = grasp_,
                                        .from_rest = std::move(*from_rest),
                                        .from_blend = plan_pair_on(planning, grasp_, makers),
                                        .abort_if = {options_.abort_if}},
                                       options_);
    prepared.verdict = [options = options_](const RunView& run) { return motion_diagnostics(run, 1, options); };
    return prepared;
  }

 private:
  /// The arms still hold C in one pose.
  [[nodiscard]] Diagnostics check_grasp(const motion::ArmPair& pair, const JointVector& q_leader,
                                        const JointVector& q_follower) const {
    const Eigen::Isometry3d by_leader = pair.X_FL * pair.leader.chain.forward(q_leader) * pair.leader.X_FM;
    const Eigen::Isometry3d by_follower = pair.follower.chain.forward(q_follower) * pair.follower.X_FM;
    const double apart = (by_leader.translation() - by_follower.translation()).norm();
    const double turned = Eigen::AngleAxisd(by_leader.linear().transpose() * by_follower.linear()).angle();
    Diagnostics diagnostics;
    constexpr double kApart = 1e-6, kTurned = 1e-6;  // m, rad
    if (apart > kApart || turned > kTurned)
      diagnostics.error(
          Code::kUnknownPosition, "/grasp",
          fmt::format("the arms disagree about the motion centre by {:.3g} mm and {:.3g} rad", 1e3 * apart, turned),
          "create TwoArms again where they are, or move each arm back to where it took hold");
    return diagnostics;
  }

  [[nodiscard]] motion::LegMaker maker(const ArmModel& leader) const {
    return [this, &leader](const JointVector& q) -> Result<motion::Leg> {
      auto leg = leg_(leader, q);
      if (!leg) return leg;
      leg->velocity = options_.velocity;
      leg->acceleration = options_.acceleration;
      leg->linear_velocity = options_.linear_velocity;
      return leg;
    };
  }

  Grasp grasp_;
  LegOf leg_;
  MotionOptions options_;
};

/// The pose of an arm's base in the world.
Eigen::Isometry3d base_of(const Actuator& arm) { return arm.frame("world").inverse(); }

}  // namespace

TwoArms::TwoArms(const Actuator& leader, const Actuator& follower, const Eigen::Isometry3d& X_WC)
    : runtime_(&leader.runtime()), leader_(leader), follower_(follower) {
  Diagnostics wrong;
  if (leader.name() == follower.name())
    wrong.error(Code::kConflict, "/follower", fmt::format("'{}' is the leader too", follower.name()), "two arms");
  if (&leader.runtime() != &follower.runtime())
    wrong.error(Code::kRequires, "/follower",
                fmt::format("'{}' belongs to another runtime than '{}'", follower.name(), leader.name()),
                "arms of one Runtime");
  if (wrong.has_errors()) throw ActivityError(std::move(wrong));
  (void)leader.use<LinInterface>();
  (void)follower.use<LinInterface>();
  grasp_ = {.leader = leader.name(),
            .follower = follower.name(),
            .X_WL = base_of(leader),
            .X_WF = base_of(follower),
            .X_HL = {},
            .X_HF = {}};
  grasp_.X_HL = leader.flange().inverse() * grasp_.X_WL.inverse() * X_WC;
  grasp_.X_HF = follower.flange().inverse() * grasp_.X_WF.inverse() * X_WC;
}

Activity TwoArms::motion(PathKind kind, const char* label, LegOf leg, const MotionParameters& parameters) const {
  MotionTask own{parameters};
  own.arm = leader_.name();
  own.follower = follower_.name();
  const auto accepted = motion_parameters(kind).accept(own, runtime_->cell());
  if (!accepted)
    return {*runtime_, refused_activity(own.arm + "+" + own.follower + " " + label, own.arm, accepted.error())};
  return {*runtime_, std::make_shared<const TwoArmActivity>(
                         label, grasp_, std::move(leg), options_of(*accepted, runtime_->cell(), runtime_->biases()))};
}

Activity TwoArms::lin(const Eigen::Isometry3d& X_WC, const MotionParameters& parameters) const {
  const Eigen::Isometry3d X_LC = grasp_.X_WL.inverse() * X_WC;
  return motion(
      PathKind::kLin, "LIN",
      [X_LC](const ArmModel& arm, const JointVector& q) { return motion::lin_leg(arm, q, X_LC); }, parameters);
}

Activity TwoArms::lin_by(const Eigen::Vector3d& way_W, const MotionParameters& parameters) const {
  const Eigen::Vector3d way_L = grasp_.X_WL.linear().transpose() * way_W;
  return motion(
      PathKind::kLin, "LIN",
      [way_L](const ArmModel& arm, const JointVector& q) {
        Eigen::Isometry3d X = arm.chain.forward(q) * arm.X_FM;
        X.translation() += way_L;
        return motion::lin_leg(arm, q, X);
      },
      parameters);
}

Activity TwoArms::circ(const motion::ArcThrough& arc_W, const MotionParameters& parameters) const {
  motion::ArcThrough arc = arc_W;
  arc.p_via = grasp_.X_WL.inverse() * arc_W.p_via;
  arc.X_BM_goal = grasp_.X_WL.inverse() * arc_W.X_BM_goal;
  return motion(
      PathKind::kCirc, "CIRC",
      [arc](const ArmModel& arm, const JointVector& q) { return motion::circ_leg(arm, q, arc); }, parameters);
}

Eigen::Isometry3d TwoArms::centre() const { return grasp_.X_WL * leader_.flange() * grasp_.X_HL; }
Eigen::Isometry3d TwoArms::centre_by_follower() const { return grasp_.X_WF * follower_.flange() * grasp_.X_HF; }

}  // namespace takt::activity
