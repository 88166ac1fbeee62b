// CarriedLine (path.h).
#include "core/motion/path.h"

namespace takt::motion {
namespace {

/// A frame that moves in B.
struct MovingFrame {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = v;      ///< of its origin, m/s; rad/s
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), alpha = a;  ///< m/s^2, rad/s^2
};

/// A frame fixed to a body, X_FA in it.
MovingFrame fixed_to(const MovingFrame& F, const Eigen::Isometry3d& X_FA) {
  const Eigen::Vector3d r = F.X.linear() * X_FA.translation();
  return {.X = F.X * X_FA,
          .v = F.v + F.w.cross(r),
          .w = F.w,
          .a = F.a + F.alpha.cross(r) + F.w.cross(F.w.cross(r)),
          .alpha = F.alpha};
}

/// Where the body of a carrier is that drives from start to goal in proportion.
MovingFrame driven(const Eigen::Vector3d& start, const Eigen::Vector3d& goal, const PathPoint& at) {
  const Eigen::Vector3d way = goal - start;
  const Eigen::Vector3d place = at.s >= 1.0 ? goal : Eigen::Vector3d(start + at.s * way);
  MovingFrame F;
  F.X.translation() << place.x(), place.y(), 0.0;
  F.X.linear() = Eigen::AngleAxisd(place.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  F.v << at.ds * way.x(), at.ds * way.y(), 0.0;
  F.a << at.dds * way.x(), at.dds * way.y(), 0.0;
  F.w.z() = at.ds * way.z();
  F.alpha.z() = at.dds * way.z();
  return F;
}

/// A motion in B, seen from a frame A that moves there: relative velocities, and accelerations without those of A, of
/// its turning and of Coriolis. Source: kinematics of relative motion, any textbook of mechanics.
FrameSample seen_from(const MovingFrame& A, const FrameSample& M) {
  const Eigen::Matrix3d R_AB = A.X.linear().transpose();
  const Eigen::Vector3d r = M.X_BM.translation() - A.X.translation();
  const Eigen::Vector3d v = M.V_BM_B.head<3>() - A.v - A.w.cross(r);
  const Eigen::Vector3d w = M.V_BM_B.tail<3>() - A.w;
  FrameSample seen;
  seen.X_BM = A.X.inverse() * M.X_BM;
  seen.V_BM_B << R_AB * v, R_AB * w;
  seen.A_BM_B << R_AB * (M.A_BM_B.head<3>() - A.a - A.alpha.cross(r) - A.w.cross(A.w.cross(r)) - 2.0 * A.w.cross(v)),
      R_AB * (M.A_BM_B.tail<3>() - A.alpha - A.w.cross(w));
  return seen;
}

}  // namespace

FrameSample CarriedLine::sample(const PathPoint& at) const {
  return seen_from(fixed_to(driven(carrier_start, carrier_goal, at), X_FA), line.sample(at));
}

}  // namespace takt::motion
