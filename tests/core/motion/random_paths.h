#pragma once

#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/inverse.h"
#include "core/motion/leg.h"
#include "tests/core/kinematics/robots.h"

namespace takt::motion::test {

/// An arm with limits of its own, drawn at random.
struct RandomArm {
  RandomArm(const std::string& urdf, Random& random);

  [[nodiscard]] ArmModel model() const { return {chain, &inverse, limits, cartesian, X_FM}; }
  [[nodiscard]] JointVector good_q(Random& random) const;  ///< away from limits and singularities

  kinematics::Chain chain;
  kinematics::InverseKinematics inverse;
  JointLimits limits;
  CartesianLimits cartesian;
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();
};

[[nodiscard]] Eigen::Isometry3d nearby(Random& random, const Eigen::Isometry3d& X, double metres, double radians);

/// A motion of a random kind near where the arm is: PTP, LIN, CIRC through a point or about an axis, spline through
/// joints or poses. @param size  m and rad. It may turn out that the arm cannot do it.
[[nodiscard]] LegMaker random_leg(Random& random, const RandomArm& arm, double size, const Blend& blend);

/// Joint positions along a planned path as inverse kinematics finds them, at the given s.
[[nodiscard]] std::vector<JointVector> joints_along(const RandomArm& arm, const Motion& motion,
                                                    const std::vector<double>& s);

}  // namespace takt::motion::test
