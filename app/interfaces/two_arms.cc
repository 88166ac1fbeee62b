#include "app/interfaces/two_arms.h"

#include <utility>

#include <fmt/format.h>

namespace takt::app {
namespace {

operations::Goal in_world(const Eigen::Isometry3d& X_W) {
  return operations::Goal{operations::Goal::Pose{.in = std::string(world::FrameGraph::kWorld), .X = X_W}};
}

/// The pose of an arm's base in the world.
Eigen::Isometry3d base_of(const Actuator& arm) { return arm.frame("world").inverse(); }

}  // namespace

TwoArms::TwoArms(const Actuator& leader, const Actuator& follower, const Eigen::Isometry3d& X_WC)
    : runtime_(&leader.runtime()), leader_(leader), follower_(follower) {
  Diagnostics wrong;
  if (leader.name() == follower.name())
    wrong.error(Code::kConflict, "/follower", fmt::format("'{}' is the leader too", follower.name()), "Name two arms");
  if (&leader.runtime() != &follower.runtime())
    wrong.error(Code::kRequires, "/follower",
                fmt::format("'{}' belongs to another runtime than '{}'", follower.name(), leader.name()),
                "Use arms of one Runtime");
  if (wrong.has_errors()) throw activity::ActivityError(std::move(wrong));
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

activity::Activity TwoArms::motion(operations::MotionTask task) const {
  task.arm = leader_.name();
  task.follower = follower_.name();
  task.X_FM = grasp_.X_HL;
  task.X_HF = grasp_.X_HF;
  return planned_motion(*runtime_, std::move(task));
}

activity::Activity TwoArms::lin(const Eigen::Isometry3d& X_WC, const operations::MotionParameters& parameters) const {
  operations::MotionTask task{parameters};
  task.kind = operations::PathKind::kLin;
  task.goal = in_world(X_WC);
  return motion(std::move(task));
}

activity::Activity TwoArms::lin_by(const Eigen::Vector3d& way_W, const operations::MotionParameters& parameters) const {
  operations::MotionTask task{parameters};
  task.kind = operations::PathKind::kLin;
  task.goal =
      operations::Goal{operations::Goal::Step{.in = std::string(world::FrameGraph::kWorld), .translation = way_W}};
  return motion(std::move(task));
}

activity::Activity TwoArms::circ(const motion::ArcThrough& arc_W,
                                 const operations::MotionParameters& parameters) const {
  operations::MotionTask task{parameters};
  task.kind = operations::PathKind::kCirc;
  task.goal = in_world(arc_W.X_BM_goal);
  task.via = in_world(Eigen::Isometry3d(Eigen::Translation3d(arc_W.p_via)));
  task.orientation = arc_W.orientation;
  return motion(std::move(task));
}

Eigen::Isometry3d TwoArms::centre() const { return grasp_.X_WL * leader_.flange() * grasp_.X_HL; }
Eigen::Isometry3d TwoArms::centre_by_follower() const { return grasp_.X_WF * follower_.flange() * grasp_.X_HF; }

}  // namespace takt::app
