#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/operations/motion_plan.h"

namespace takt::activity {

/// Motions of one arm, or of two as one, as a program's steps ask for them, each blended into the next one, as an
/// activity: it may be guarded, left, and go on with what may be left. Diagnostics have pointers below the step of the
/// first motion.
class RequestedMotion : public ActivityModel {
 public:
  using ActivityModel::ActivityModel;

  /// What it is when nothing precedes it.
  struct Alone {
    PlannedActivity prepared;
    Diagnostics notes;                                                   ///< of the planner, with pointers of the file
    std::map<std::string, kinematics::JointVector, std::less<>> q_goal;  ///< of each arm, rad or m
    double duration = 0.0;                                               ///< s
  };
  /// @param q  where each of its arms is, rad or m
  /// @param surroundings  what a `move` avoids
  [[nodiscard]] virtual Result<Alone> alone(const command::Cell& cell,
                                            const std::map<std::string, kinematics::JointVector, std::less<>>& q,
                                            const Surroundings& surroundings) const = 0;
};

/// @param requests  at least one, all of the same arm, or of the same two
/// @param biases    of the sensors in their conditions
/// @param meanwhile  what others do while a `move` among them is carried out
[[nodiscard]] std::shared_ptr<const RequestedMotion> requested_motion(const std::vector<MotionTask>& requests,
                                                                      command::Biases biases, Meanwhile meanwhile = {});

}  // namespace takt::activity
