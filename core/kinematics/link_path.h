#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/robot_model.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// The joints between the base link B of an arm and one link L that they move: where L is and how it moves. A Chain
/// knows the flange alone. Immutable and thread-safe.
class LinkPath {
 public:
  /// X_BL for positions of all joints of the arm, rad or m. Realtime: cyclic.
  [[nodiscard]] Eigen::Isometry3d pose(const JointVector& q) const;
  /// The same, and the velocity of L in B: [v_BL_B; w_BL_B], m/s and rad/s. Realtime: cyclic.
  struct Motion {
    Eigen::Isometry3d X_BL;
    Vector6 V_BL_B;
  };
  [[nodiscard]] Motion motion(const JointVector& q, const JointVector& dq) const;

 private:
  friend class LinkPaths;
  struct Step {
    Eigen::Isometry3d X_PJ;  ///< the joint's frame in the one before, fixed joints included
    Eigen::Vector3d axis;    ///< in J
    bool prismatic = false;
    Eigen::Index joint = 0;  ///< in the order of the arm
  };
  std::vector<Step> steps_;
  Eigen::Isometry3d X_JL_ = Eigen::Isometry3d::Identity();  ///< L in the frame that the last joint moves
};

/// All links that the joints of an arm move, by name.
class LinkPaths {
 public:
  /// @param base_link  of that model   @param joints  names of the arm's joints in its order; links that hang on
  /// another movable joint are left out. Realtime: setup.
  LinkPaths(const RobotModel& model, const std::string& base_link, std::span<const std::string> joints);

  /// Null: these joints move no such link. Realtime: cyclic.
  [[nodiscard]] const LinkPath* find(std::string_view link) const;
  /// In the order of the alphabet. Realtime: setup.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::map<std::string, LinkPath, std::less<>> paths_;
};

}  // namespace takt::kinematics
