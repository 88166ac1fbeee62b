#pragma once

#include <string>

#include "app/interfaces/actuator_interfaces.h"
#include "core/activity/pair_motion.h"
#include "core/expression/condition_state.h"

namespace takt::app {

/// Two arms as one actuator that moves one frame C, the common motion centre: a part that both hold. One path, one law,
/// one clock; both are started, paused, cancelled and stopped in the same cycle and on the path. The grasp is what it
/// was when this was made. Poses are in the world, m. Thread: the program's. Realtime: setup.
class TwoArms {
 public:
  /// @param X_WC  where C is now; both arms rest. Throws ActivityError if one of them cannot, and if
  /// they are not two of one runtime.
  TwoArms(const Actuator& leader, const Actuator& follower, const Eigen::Isometry3d& X_WC);

  [[nodiscard]] activity::Activity lin(const Eigen::Isometry3d& X_WC,
                                       const operations::MotionParameters& parameters = {}) const;
  /// From wherever C will be, by this much in the axes of the world.
  [[nodiscard]] activity::Activity lin_by(const Eigen::Vector3d& way_W,
                                          const operations::MotionParameters& parameters = {}) const;
  /// Through a via point; orientations as in motion::ArcThrough.
  [[nodiscard]] activity::Activity circ(const motion::ArcThrough& arc_W,
                                        const operations::MotionParameters& parameters = {}) const;
  /// C by the set points of now, as the leader and as the follower have it.
  [[nodiscard]] Eigen::Isometry3d centre() const;
  [[nodiscard]] Eigen::Isometry3d centre_by_follower() const;

  using Grasp = activity::Grasp;
  [[nodiscard]] const activity::Grasp& grasp() const { return grasp_; }

 private:
  [[nodiscard]] activity::Activity motion(operations::MotionTask task) const;

  activity::Runtime* runtime_;
  Actuator leader_, follower_;
  activity::Grasp grasp_;
};

using expression::internal_force;

}  // namespace takt::app
