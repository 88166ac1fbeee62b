#pragma once

#include <vector>

#include "core/activity/activity_model.h"
#include "core/activity/motion_request.h"

namespace takt::activity {

/// Motions of one arm as a program's steps ask for them, each blended into the next one, as an activity: it may be
/// guarded, left, and go on with what may be left.
class RequestedMotion final : public ActivityModel {
 public:
  /// @param requests  at least one, all of one arm
  /// @param biases    of the sensors in the condition of the last one
  RequestedMotion(const std::vector<MotionRequest>& requests, command::Biases biases);

  [[nodiscard]] std::vector<std::string> actuators() const override { return {requests_.back().arm}; }
  /// Findings have pointers below the step of the first motion.
  [[nodiscard]] Result<Prepared> prepare(const Situation& situation) const override;
  /// The same with the plan from rest at hand (plan_motions); `situation` may know of no precedent.
  [[nodiscard]] Prepared prepare(const Situation& situation, motion::SequencePlan from_rest) const;

 private:
  [[nodiscard]] std::optional<motion::SequencePlan> blended_plan(const Situation& situation) const;

  std::vector<MotionRequest> requests_;
  command::Biases biases_;
};

}  // namespace takt::activity
