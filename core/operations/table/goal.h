#pragma once

#include <string>
#include <string_view>
#include <variant>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/table/parameter.h"

namespace takt::operations {

/// Where a motion goes.
///   "home"                                                 the posture of the model's device file; {"home": true} too
///   {"joints_deg": [...]}                                  joint positions
///   either with "absolute": true                           a joint without limits takes back all its turns; else the
///                                                          turn that is nearest to where it is
///   {"in": FRAME, "position_m": [...], "rpy_deg": [...]}    tool centre point in a frame; without an orientation that
///                                                          of the tool is kept
///   {"by_m": [...], "in": FRAME, "by_rpy_deg": [...]}       step from the present set point, along the axes of a frame
///                                                          ("tcp": of the tool); turned about the tool's own axes
struct Goal {
  struct Home {};
  struct Joints {
    kinematics::JointVector q;
  };
  struct Pose {
    std::string in;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    bool keep_orientation = false;
  };
  struct Step {
    std::string in;
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  };
  /// Programs: one joint, to a position or by a distance, while the others rest.
  struct OneJoint {
    int joint = 0;   ///< from 0
    double q = 0.0;  ///< rad or m
    bool by = false;
  };
  std::variant<Home, Joints, Pose, Step, OneJoint> value;
  /// Of home, joints and one joint: a joint without limits takes back all its turns.
  bool absolute = false;

  /// Given as joint positions, not as a pose.
  [[nodiscard]] bool is_joints() const {
    return !std::holds_alternative<Pose>(value) && !std::holds_alternative<Step>(value);
  }
};

/// The keys of all forms of a goal, for the tables of operations.
[[nodiscard]] const std::vector<ParameterInfo>& goal_fields();

/// Reads key "to" of a motion step (or another key). Diagnostics in the reader: not a goal, numbers that do not fit the
/// arm.
/// @param arm  null if the step names no arm that exists; then the number of joints is not checked. Realtime: setup.
[[nodiscard]] Goal read_goal(ObjectReader& reader, const expression::MountedArm* arm, std::string_view key = "to");
/// Reads a goal that stands at `pointer`, in a list.
[[nodiscard]] Goal read_goal(const nlohmann::ordered_json& json, const std::string& pointer,
                             const expression::MountedArm* arm, Diagnostics& diagnostics);

/// A goal in numbers: joint positions, or the pose of the tool centre point T in the arm's base B.
using ResolvedGoal = std::variant<kinematics::JointVector, Eigen::Isometry3d>;

/// @param arm  name of an arm of the cell
/// @param q    where its set point is, rad or m
/// @return the goal, or a diagnostic for an unknown frame. Realtime: setup.
[[nodiscard]] Result<ResolvedGoal> resolve(const Goal& goal, const expression::Cell& cell, const std::string& arm,
                                           const kinematics::JointVector& q);

/// Where the goal lies changes while machines move: it is given in a frame that does. Not of the arm's own tool, from
/// which steps are counted.
[[nodiscard]] bool depends_on_moving_frame(const Goal& goal, const expression::Cell& cell, const std::string& arm);

}  // namespace takt::operations
