#include "core/motion/path_curve.h"

#include <Eigen/LU>

namespace takt::motion {
namespace {

template <class T>
Jet<T> by_time(const Jet<T>& f, const PathPoint& at) {
  return {.value = f.value, .first = f.first * at.ds, .second = f.second * (at.ds * at.ds) + f.first * at.dds};
}

JointSample joint_sample(const Quintic<JointVector>& q, const PathPoint& at) {
  const Jet<JointVector> f = by_time(q.at(at.s), at);
  return {.q = f.value, .dq = f.first, .ddq = f.second};
}

}  // namespace

JointSample JointCurve::sample(const PathPoint& at) const { return joint_sample(q, at); }

CartesianCurve CartesianCurve::between(const FrameJet& a, const FrameJet& b) {
  CartesianCurve curve;
  // The orientation in the middle: both ends are then less than a quarter of a turn away from it.
  const Eigen::Vector3d way = log_rotation(b.R * a.R.transpose());
  curve.R_ref = Eigen::Quaterniond(exp_rotation(0.5 * way) * a.R).normalized();
  curve.p = Quintic<Eigen::Vector3d>::between(a.p, b.p);
  const auto turn = [&](const FrameJet& end) -> Jet<Eigen::Vector3d> {
    const RotationVector v =
        rotation_vector(log_rotation(end.R * curve.R_ref.toRotationMatrix().transpose()), end.turn);
    return {.value = v.phi, .first = v.dphi, .second = v.ddphi};
  };
  curve.phi = Quintic<Eigen::Vector3d>::between(turn(a), turn(b));
  curve.held_curve = Quintic<JointVector>::between(a.held, b.held);
  return curve;
}

FrameSample CartesianCurve::sample(const PathPoint& at) const {
  const Jet<Eigen::Vector3d> origin = by_time(p.at(at.s), at);
  const Jet<Eigen::Vector3d> turn = by_time(phi.at(at.s), at);
  const AngularMotion angular = angular_motion({.phi = turn.value, .dphi = turn.first, .ddphi = turn.second});
  FrameSample sample;
  sample.X_BM.translation() = origin.value;
  sample.X_BM.linear() = exp_rotation(turn.value) * R_ref.toRotationMatrix();
  sample.V_BM_B << origin.first, angular.w;
  sample.A_BM_B << origin.second, angular.alpha;
  return sample;
}

JointSample CartesianCurve::held(const PathPoint& at) const { return joint_sample(held_curve, at); }

SplineKnots interpolate(const std::vector<double>& knots, const Eigen::MatrixXd& points) {
  // Unknown are first and second derivative at each knot (d_i, s_i). In a span of width h the third derivative by u at
  // its ends is, from the coefficients of the quintic,
  //   left   f'''  = (60 rise - 36 h d0 - 24 h d1 - 9 h^2 s0 + 3 h^2 s1) / h^3
  //   right  f'''  = (60 rise - 24 h d0 - 36 h d1 - 3 h^2 s0 + 9 h^2 s1) / h^3
  //   left   f'''' = (-360 rise + 192 h d0 + 168 h d1 + 36 h^2 s0 - 24 h^2 s1) / h^4
  //   right  f'''' = ( 360 rise - 168 h d0 - 192 h d1 - 24 h^2 s0 + 36 h^2 s1) / h^4
  // and both are equal from both sides at inner knots, and zero at the ends.
  const auto n = static_cast<Eigen::Index>(knots.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(2 * n, points.cols());
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const double h = knots[static_cast<std::size_t>(i) + 1] - knots[static_cast<std::size_t>(i)];
    const Eigen::RowVectorXd rise = points.row(i + 1) - points.row(i);
    const auto add = [&](Eigen::Index row, double sign, double f, double d0, double d1, double s0, double s1,
                         double scale) {
      A(row, 2 * i) += sign * d0 * h / scale;
      A(row, 2 * i + 1) += sign * s0 * h * h / scale;
      A(row, 2 * i + 2) += sign * d1 * h / scale;
      A(row, 2 * i + 3) += sign * s1 * h * h / scale;
      rhs.row(row) -= sign * f * rise / scale;
    };
    const double h3 = h * h * h;
    const double h4 = h3 * h;
    add(2 * i, -1.0, 60, -36, -24, -9, 3, h3);
    add(2 * i + 1, -1.0, -360, 192, 168, 36, -24, h4);
    add(2 * i + 2, 1.0, 60, -24, -36, -3, 9, h3);
    add(2 * i + 3, 1.0, 360, -168, -192, -24, 36, h4);
  }
  const Eigen::MatrixXd x = A.partialPivLu().solve(rhs);
  SplineKnots result{.first = Eigen::MatrixXd(n, points.cols()), .second = Eigen::MatrixXd(n, points.cols())};
  for (Eigen::Index i = 0; i < n; ++i) {
    result.first.row(i) = x.row(2 * i);
    result.second.row(i) = x.row(2 * i + 1);
  }
  return result;
}

}  // namespace takt::motion
