#pragma once

#include <variant>

#include <Eigen/Core>

namespace takt::kinematics {

/// The wheels of a base with four mecanum wheels whose rollers cross as an X seen from above: any motion in the plane.
/// Frames: D = middle between the four wheels on the floor, x forward, y to the left, z up.
/// Order of the wheels: front left, front right, rear left, rear right; a wheel turns about +y to drive forward.
/// Source: the rolling condition of a 45 degree roller; robots.md section 4 of the project's references gives the same
/// rows for the youBot.
struct MecanumDrive {
  static constexpr int kWheels = 4;
  using Wheels = Eigen::Vector4d;

  double wheel_radius = 0.0;  ///< m
  double wheelbase = 0.0;     ///< m, from the front axle to the rear one
  double track = 0.0;         ///< m, between the middles of the left and the right wheels

  /// Half wheelbase and half track: the way of a wheel's contact for a radian of the body, m. Realtime: cyclic.
  [[nodiscard]] double lever() const { return 0.5 * (wheelbase + track); }

  /// Speeds of the wheels, rad/s, for the body's motion (vx, vy in m/s, wz in rad/s) in its own axes; no wheel slips.
  /// Realtime: cyclic.
  [[nodiscard]] Wheels wheel_speeds(const Eigen::Vector3d& twist) const {
    const double forward = twist.x(), left = twist.y(), turn = lever() * twist.z();
    return Wheels(forward - left - turn, forward + left + turn, forward + left - turn, forward - left + turn) /
           wheel_radius;
  }

  /// The body's motion for speeds of the wheels; wheels that disagree give the one that fits best (least squares), as
  /// wheel odometry does. Realtime: cyclic.
  [[nodiscard]] Eigen::Vector3d body_motion(const Wheels& w) const {
    const double quarter = 0.25 * wheel_radius;
    return {quarter * (w[0] + w[1] + w[2] + w[3]), quarter * (-w[0] + w[1] + w[2] - w[3]),
            quarter * (-w[0] + w[1] - w[2] + w[3]) / lever()};
  }

  /// The largest wheel speed, rad/s, over all directions in which the body moves with `linear` m/s while it turns with
  /// up to `angular` rad/s: driving at 45 degrees is the worst. Realtime: cyclic.
  [[nodiscard]] double fastest_wheel(double linear, double angular) const {
    constexpr double kDiagonal = 1.4142135623730951;
    return (kDiagonal * linear + lever() * angular) / wheel_radius;
  }

  /// Inertia that wheels of `axial` kg m^2 about their axles add to the body along x, y (kg) and about z (kg m^2): they
  /// turn whichever way it moves. Realtime: setup.
  [[nodiscard]] Eigen::Vector3d reflected_inertia(double axial) const {
    const double mass = kWheels * axial / (wheel_radius * wheel_radius);
    return {mass, mass, mass * lever() * lever()};
  }
};

/// The wheels of a base with two driven wheels on one axle, and casters that follow: it drives ahead, back and turns,
/// but does not go sideways. Frames: D = middle between the two wheels on the floor, x forward, y to the left, z up.
/// Order of the wheels: left, right; a wheel turns about +y to drive forward.
/// Source: the rolling condition of a disc (Siegwart, Nourbakhsh, Introduction to Autonomous Mobile Robots, 3.2.3).
struct DifferentialDrive {
  static constexpr int kWheels = 2;
  using Wheels = Eigen::Vector2d;

  double wheel_radius = 0.0;       ///< m
  double track = 0.0;              ///< m, between the middles of the two wheels
  double lateral_stiffness = 0.0;  ///< N/m: of both tyres against the floor, sideways
  double lateral_force = 0.0;      ///< N: with more the tyres slip sideways

  /// Realtime: cyclic.
  [[nodiscard]] double lever() const { return 0.5 * track; }

  /// As of MecanumDrive; what a twist has along y turns no wheel.
  [[nodiscard]] Wheels wheel_speeds(const Eigen::Vector3d& twist) const {
    const double forward = twist.x(), turn = lever() * twist.z();
    return Wheels(forward - turn, forward + turn) / wheel_radius;
  }

  /// Realtime: cyclic.
  [[nodiscard]] Eigen::Vector3d body_motion(const Wheels& w) const {
    return {0.5 * wheel_radius * (w[0] + w[1]), 0.0, 0.5 * wheel_radius * (w[1] - w[0]) / lever()};
  }

  /// Realtime: cyclic.
  [[nodiscard]] double fastest_wheel(double linear, double angular) const {
    return (linear + lever() * angular) / wheel_radius;
  }

  /// Along x; along y, where the base does not move, the same is said, so that the axes of its odometry may be any.
  /// Realtime: setup.
  [[nodiscard]] Eigen::Vector3d reflected_inertia(double axial) const {
    const double mass = kWheels * axial / (wheel_radius * wheel_radius);
    return {mass, mass, mass * lever() * lever()};
  }
};

/// What a base drives on.
using WheelDrive = std::variant<MecanumDrive, DifferentialDrive>;

/// Speeds of the wheels in the order of the drive, at most four, rad/s. Realtime: cyclic.
using WheelSpeeds = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, MecanumDrive::kWheels, 1>;
[[nodiscard]] inline WheelSpeeds wheel_speeds(const WheelDrive& drive, const Eigen::Vector3d& twist) {
  return std::visit([&](const auto& one) { return WheelSpeeds(one.wheel_speeds(twist)); }, drive);
}
[[nodiscard]] inline double fastest_wheel(const WheelDrive& drive, double linear, double angular) {
  return std::visit([&](const auto& one) { return one.fastest_wheel(linear, angular); }, drive);
}
[[nodiscard]] inline int wheel_count(const WheelDrive& drive) {
  return std::visit([](const auto& one) { return one.kWheels; }, drive);
}
/// A base that cannot go sideways. Realtime: cyclic.
[[nodiscard]] inline bool is_nonholonomic(const WheelDrive& drive) {
  return std::holds_alternative<DifferentialDrive>(drive);
}

}  // namespace takt::kinematics
