#include "core/motion/goal_choice.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/kinematics/joint_range.h"
#include "core/kinematics/solutions.h"
#include "core/motion/plan_checks.h"

namespace takt::motion {

Result<JointVector> choose_solution(const kinematics::Chain& chain, const JointLimits& limits,
                                    const Eigen::Isometry3d& X_BF, const JointVector& q_near,
                                    const std::optional<JointVector>& weights) {
  Diagnostics diagnostics;
  check_limits(chain, limits, diagnostics);
  check_pose(X_BF, "/goal", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const JointVector weight = weights.value_or(limits.velocity.cwiseInverse());
  const bool fits = q_near.size() == chain.joint_count() && q_near.allFinite() && weight.size() == q_near.size();
  if (!fits) return failure(Code::kOutOfRange, "/start", "the configuration to be near to does not fit the chain");

  kinematics::SolutionOptions search;
  search.reference = q_near;
  search.turns = false;  // of each branch the nearest turn: there may be more turns than are looked at
  auto solutions = inverse_solutions(chain, X_BF, search);
  const Eigen::Vector3d p = X_BF.translation();
  if (solutions.empty()) {
    return failure(Code::kUnreachable, "/goal",
                   fmt::format("the pose is out of reach ({:.3f} m from the base)", p.norm()));
  }
  for (JointVector& q : solutions) q = kinematics::into_range(q, limits.lower, limits.upper);
  std::erase_if(solutions, [&](const JointVector& q) {
    return ((q - limits.lower).array() < 0.0).any() || ((q - limits.upper).array() > 0.0).any();
  });
  if (solutions.empty())
    return failure(Code::kUnreachable, "/goal", "the pose is reachable outside the ranges of the joints only");
  const auto distance = [&](const JointVector& q) { return weight.cwiseProduct(q - q_near).squaredNorm(); };
  // min_element keeps the first of equals, so that the answer depends on the order of the search alone.
  return *std::min_element(solutions.begin(), solutions.end(),
                           [&](const JointVector& a, const JointVector& b) { return distance(a) < distance(b); });
}

}  // namespace takt::motion
