#include "tests/core/motion/random_paths.h"

#include <gtest/gtest.h>

#include "tests/core/motion/motion_runs.h"

namespace takt::motion::test {
namespace {

namespace robots = kinematics::test;

Eigen::Vector3d random_vector(Random& random, double size) {
  return size * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}

JointVector near_q(Random& random, const JointVector& q, double size) {
  JointVector near = q;
  for (Eigen::Index i = 0; i < q.size(); ++i) near[i] += random.uniform(-size, size);
  return near;
}

}  // namespace

RandomArm::RandomArm(const std::string& urdf, Random& random)
    : chain(robots::chain_of(urdf)),
      inverse(*kinematics::InverseKinematics::create(chain)),
      limits(random_limits(random, chain)) {
  X_FM = nearby(random, X_FM, 0.1, 0.5);
}

JointVector RandomArm::good_q(Random& random) const {
  for (;;) {
    const JointVector q = 0.5 * robots::random_q(random, chain);
    if (inverse.singularity_measure(q) > 0.15) return q;
  }
}

Eigen::Isometry3d nearby(Random& random, const Eigen::Isometry3d& X, double metres, double radians) {
  Eigen::Isometry3d goal = X;
  goal.translation() += random_vector(random, metres);
  const Eigen::Vector3d axis = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  goal.linear() = Eigen::AngleAxisd(random.uniform(-radians, radians), axis) * X.linear();
  return goal;
}

LegMaker random_leg(Random& random, const RandomArm& arm, double size, const Blend& blend) {
  const auto kind = random.bits() % 6;
  const Random draw(random.bits());
  return [kind, draw, &arm, size, blend](const JointVector& q) -> Result<Leg> {
    Random own = draw;  // the same draw however often the motion is asked for
    const ArmModel model = arm.model();
    const Eigen::Isometry3d X = arm.chain.forward(q) * arm.X_FM;
    Result<Leg> leg = std::unexpected(Diagnostics{});
    if (kind == 0) {
      leg = ptp_leg(model, q, near_q(own, q, 2.0 * size));
    } else if (kind == 1) {
      leg = lin_leg(model, q, nearby(own, X, size, size));
    } else if (kind == 2) {
      leg = circ_leg(model, q,
                     ArcThrough{.p_via = X.translation() + random_vector(own, size),
                                .X_BM_goal = nearby(own, X, size, size),
                                .orientation = static_cast<ArcOrientation>(own.bits() % 3)});
    } else if (kind == 3) {
      leg = circ_leg(model, q,
                     ArcAbout{.centre = X.translation() + random_vector(own, 0.5 * size),
                              .axis = random_vector(own, 1.0),
                              .angle = own.uniform(-2.0, 2.0)});
    } else if (kind == 4) {
      std::vector<JointVector> points;
      for (int i = 0; i < 4; ++i) points.push_back(near_q(own, points.empty() ? q : points.back(), size));
      leg = spline_leg(model, q, points);
    } else {
      std::vector<Eigen::Isometry3d> poses;
      for (int i = 0; i < 4; ++i)
        poses.push_back(nearby(own, poses.empty() ? X : poses.back(), 0.6 * size, 0.5 * size));
      leg = spline_leg(model, q, poses);
    }
    if (leg) leg->blend = blend;
    return leg;
  };
}

std::vector<JointVector> joints_along(const RandomArm& arm, const Motion& motion, const std::vector<double>& s) {
  std::vector<JointVector> result;
  JointVector q = motion.q_start;
  double last = 0.0;
  for (const double at : s) {
    // In small steps, so that each solution is next to the one before even where joints go fast.
    constexpr int kSteps = 16;
    for (int i = 1; i <= kSteps; ++i) {
      const PathSample there = sample(motion.path, {.s = i == kSteps ? at : last + (at - last) * i / kSteps});
      if (!there.cartesian) {
        q = there.joints.q;
      } else {
        const auto status = arm.inverse.solve(there.frame.X_BM * arm.X_FM.inverse(), there.held.q, q);
        EXPECT_EQ(status, kinematics::IkStatus::kOk) << "at s = " << at;
      }
    }
    last = at;
    result.push_back(q);
  }
  return result;
}

}  // namespace takt::motion::test
