#include "core/activity/two_arms.h"

#include <utility>

#include <fmt/format.h>

#include "core/activity/two_ways.h"
#include "core/command/device_sensors.h"
#include "core/motion/motion_state.h"
#include "core/motion/plan_pair.h"

namespace takt::activity {
namespace {

using command::Cell;
using kinematics::JointVector;
using motion::ArmModel;

ArmModel model_of(const Cell& cell, const std::string& arm, const Eigen::Isometry3d& X_FM) {
  return command::planning_model(cell.arms.find(arm)->second, X_FM);
}

class TwoArmActivity final : public ActivityModel {
 public:
  TwoArmActivity(const std::string& kind, TwoArms::Grasp grasp, LegOf leg, MotionParameters wish)
      : ActivityModel(fmt::format("{}+{} {}", grasp.leader, grasp.follower, kind)),
        grasp_(std::move(grasp)),
        leg_(std::move(leg)),
        wish_(std::move(wish)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {grasp_.leader, grasp_.follower}; }

  [[nodiscard]] Result<Prepared> prepare(const Situation& situation) const override {
    Findings wrong;
    check_blend(wish_, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    const Precedent& leads = situation.precedents.find(grasp_.leader)->second;
    const Precedent& follows = situation.precedents.find(grasp_.follower)->second;
    if (!leads.at_end.rests() || !follows.at_end.rests())
      return failure("", fmt::format("'{}': nobody knows where the arms will be at rest", name()),
                     "a motion after the end of what runs");
    const motion::ArmPair pair{.leader = model_of(situation.cell, grasp_.leader, grasp_.X_HL),
                               .follower = model_of(situation.cell, grasp_.follower, grasp_.X_HF),
                               .X_FL = grasp_.X_WF.inverse() * grasp_.X_WL};
    if (Findings apart = check_grasp(pair, *leads.at_end.q, *follows.at_end.q); apart.has_errors())
      return std::unexpected(std::move(apart));
    const std::vector<motion::LegMaker> makers{maker(pair.leader)};
    auto from_rest = motion::plan_pair(pair, *leads.at_end.q, *follows.at_end.q, makers);
    if (!from_rest) return std::unexpected(std::move(from_rest.error()));
    TwoWays ways{.name = name(),
                 .actuator = command::arm_pair(situation.cell, grasp_.leader, grasp_.follower),
                 .clock = grasp_.leader,
                 .from_rest = planned(std::move(*from_rest))};
    ways.begins[grasp_.leader].rest = seam_at_rest(*leads.at_end.q);
    ways.begins[grasp_.follower].rest = seam_at_rest(*follows.at_end.q);
    add_blend(pair, leads, makers, ways);
    return prepare_two_ways(situation, std::move(ways), wish_);
  }

 private:
  /// The arms still hold C at one place.
  [[nodiscard]] Findings check_grasp(const motion::ArmPair& pair, const JointVector& q_leader,
                                     const JointVector& q_follower) const {
    const Eigen::Isometry3d by_leader = pair.X_FL * pair.leader.chain.forward(q_leader) * pair.leader.X_FM;
    const Eigen::Isometry3d by_follower = pair.follower.chain.forward(q_follower) * pair.follower.X_FM;
    const double apart = (by_leader.translation() - by_follower.translation()).norm();
    const double turned = Eigen::AngleAxisd(by_leader.linear().transpose() * by_follower.linear()).angle();
    Findings findings;
    constexpr double kApart = 1e-6, kTurned = 1e-6;  // m, rad
    if (apart > kApart || turned > kTurned)
      findings.error("/grasp",
                     fmt::format("the arms see the motion centre {:.3g} mm and {:.3g} rad apart", 1e3 * apart, turned),
                     "TwoArms anew where they are, or a motion of each to where they took hold");
    return findings;
  }

  [[nodiscard]] motion::LegMaker maker(const ArmModel& leader) const {
    return [this, &leader](const JointVector& q) -> Result<motion::Leg> {
      auto leg = leg_(leader, q);
      if (!leg) return leg;
      leg->velocity = wish_.velocity;
      leg->acceleration = wish_.acceleration;
      leg->linear_velocity = wish_.linear_velocity;
      return leg;
    };
  }

  [[nodiscard]] command::PlannedMotion planned(motion::PairPlan plan) const {
    return {.motion = std::make_shared<const motion::Motion>(std::move(plan.leader)),
            .X_FM = grasp_.X_HL,
            .handed_over = {},
            .clock = {},
            .name = name(),
            .partner =
                command::PlannedPartner{std::make_shared<const motion::Motion>(std::move(plan.follower)), grasp_.X_HF}};
  }

  void add_blend(const motion::ArmPair& pair, const Precedent& leads, const std::vector<motion::LegMaker>& makers,
                 TwoWays& ways) const {
    if (!leads.leaving || leads.leaving->motion.partner == nullptr) return;
    const auto& leaving = *leads.leaving;
    auto plan = motion::plan_pair_take_over(
        pair,
        {.motion = *leaving.motion.motion, .tau = leaving.tau, .lead = leaving.lead, .blend = leaving.motion.blend},
        *leaving.motion.partner, makers);
    if (!plan) return;
    const auto first = motion::joints_at(pair.leader, plan->leader, 0.0);
    const auto second = motion::joints_at(pair.follower, plan->follower, 0.0);
    if (!first || !second) return;
    ways.begins[grasp_.leader].blend = seam_in_motion(leaving, *first);
    ways.begins[grasp_.follower].blend = seam_in_motion(leaving, *second);
    ways.tau = leaving.tau;
    ways.from_blend = planned(std::move(*plan));
  }

  TwoArms::Grasp grasp_;
  LegOf leg_;
  MotionParameters wish_;
};

/// The pose of an arm's base in the world.
Eigen::Isometry3d base_of(const Actuator& arm) { return arm.frame("world").inverse(); }

}  // namespace

TwoArms::TwoArms(const Actuator& leader, const Actuator& follower, const Eigen::Isometry3d& X_WC)
    : runtime_(&leader.runtime()), leader_(leader), follower_(follower) {
  Findings wrong;
  if (leader.name() == follower.name())
    wrong.error("/follower", fmt::format("'{}' is the leader too", follower.name()), "two arms");
  if (&leader.runtime() != &follower.runtime())
    wrong.error("/follower", fmt::format("'{}' belongs to another runtime than '{}'", follower.name(), leader.name()),
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

Activity TwoArms::motion(const char* kind, LegOf leg, const MotionParameters& parameters) const {
  return {*runtime_, std::make_shared<const TwoArmActivity>(kind, grasp_, std::move(leg), parameters)};
}

Activity TwoArms::lin(const Eigen::Isometry3d& X_WC, const MotionParameters& parameters) const {
  const Eigen::Isometry3d X_LC = grasp_.X_WL.inverse() * X_WC;
  return motion(
      "LIN", [X_LC](const ArmModel& arm, const JointVector& q) { return motion::lin_leg(arm, q, X_LC); }, parameters);
}

Activity TwoArms::lin_by(const Eigen::Vector3d& way_W, const MotionParameters& parameters) const {
  const Eigen::Vector3d way_L = grasp_.X_WL.linear().transpose() * way_W;
  return motion(
      "LIN",
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
      "CIRC", [arc](const ArmModel& arm, const JointVector& q) { return motion::circ_leg(arm, q, arc); }, parameters);
}

Eigen::Isometry3d TwoArms::centre() const { return grasp_.X_WL * leader_.flange() * grasp_.X_HL; }
Eigen::Isometry3d TwoArms::centre_by_follower() const { return grasp_.X_WF * follower_.flange() * grasp_.X_HF; }

command::RealSensor internal_force(const Cell& cell, const std::string& one_sensor, const std::string& other_sensor,
                                   const command::Biases& biases) {
  const auto in_world = [&](const std::string& name) {
    const command::VectorSensor felt = force(command::contact_wrench(cell, name, biases));
    const auto sensor = cell.sensors.find(name);
    if (sensor == cell.sensors.end()) return felt;  // the formula itself says that it is not there
    const auto X_WB = cell.frames.pose(sensor->second.arm).value_or(Eigen::Isometry3d::Identity());
    const auto X_BS = command::flange_fixed_pose(cell, sensor->second.arm, sensor->second.X_FS);
    return rotate(net::Frame(X_WB), rotate(X_BS, felt));
  };
  return 0.5 * norm(in_world(one_sensor) - in_world(other_sensor));
}

}  // namespace takt::activity
