#pragma once

#include <array>
#include <vector>

#include "core/motion/path_sample.h"
#include "core/motion/rotation_vector.h"

namespace takt::motion {

/// A value and its first and second derivative by the same parameter.
template <class T>
struct Jet {
  T value;
  T first;
  T second;
};

/// Polynomial of degree 5 over u in [0, 1]; coefficients from the constant upwards.
template <class T>
struct Quintic {
  std::array<T, 6> c;

  /// The one with these values and derivatives (by u) at both ends. Realtime: setup.
  [[nodiscard]] static Quintic between(const Jet<T>& a, const Jet<T>& b) {
    const T rise = b.value - a.value;
    return {{a.value, a.first, 0.5 * a.second,
             10.0 * rise - 6.0 * a.first - 4.0 * b.first - 1.5 * a.second + 0.5 * b.second,
             -15.0 * rise + 8.0 * a.first + 7.0 * b.first + 1.5 * a.second - b.second,
             6.0 * rise - 3.0 * a.first - 3.0 * b.first - 0.5 * a.second + 0.5 * b.second}};
  }

  /// Realtime: cyclic, no allocation.
  [[nodiscard]] Jet<T> at(double u) const {
    return {.value = c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5])))),
            .first = c[1] + u * (2.0 * c[2] + u * (3.0 * c[3] + u * (4.0 * c[4] + u * (5.0 * c[5])))),
            .second = 2.0 * c[2] + u * (6.0 * c[3] + u * (12.0 * c[4] + u * (20.0 * c[5])))};
  }
};

/// Joints on a polynomial: a span of a joint spline, or a blend.
/// As JSON: {"kind": "joint_curve", "coefficients": [six lists, from the constant upwards, rad or m]}.
struct JointCurve {
  Quintic<JointVector> q;

  /// Realtime: cyclic, no allocation.
  [[nodiscard]] JointSample sample(const PathPoint& at) const;
};

/// Motion of a frame M and of the held joints by a path parameter: what curves are made of and joined by.
struct FrameJet {
  Jet<Eigen::Vector3d> p;  ///< origin of M in B, m
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  AngularMotion turn;
  Jet<JointVector> held;
};

/// A frame M on polynomials: its origin, the rotation vector of its turn against a fixed orientation, and the held
/// joints: a span of a spline through poses, or a blend.
/// As JSON: {"kind": "cartesian_curve", "reference": [w, x, y, z], "position": [six vectors], "turn": [six vectors],
/// "held": [six lists]}.
struct CartesianCurve {
  Eigen::Quaterniond R_ref = Eigen::Quaterniond::Identity();
  Quintic<Eigen::Vector3d> p;    ///< m
  Quintic<Eigen::Vector3d> phi;  ///< rad, in B; shorter than pi
  Quintic<JointVector> held_curve;

  /// The curve with these motions (by its own u) at its ends. They are less than half a turn apart. Realtime: setup.
  [[nodiscard]] static CartesianCurve between(const FrameJet& a, const FrameJet& b);

  /// Realtime: cyclic, no allocation.
  [[nodiscard]] FrameSample sample(const PathPoint& at) const;
  [[nodiscard]] JointSample held(const PathPoint& at) const;
};

/// Interpolating spline of degree 5: through `points` at `knots`, four continuous derivatives, third and fourth zero at
/// both ends (of all interpolants the one with the least integral of the squared third derivative).
/// @param knots   at least three, increasing   @param points  one row per knot
/// @return value, first and second derivative by the knots' parameter, one row per knot. Realtime: setup.
struct SplineKnots {
  Eigen::MatrixXd first;
  Eigen::MatrixXd second;
};
[[nodiscard]] SplineKnots interpolate(const std::vector<double>& knots, const Eigen::MatrixXd& points);

}  // namespace takt::motion
