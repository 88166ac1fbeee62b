// Poses, rotations and wrenches.
#include <cmath>

#include "core/motion/rotation_vector.h"
#include "languages/urscript/arguments.h"
#include "languages/urscript/functions.h"
#include "languages/urscript/poses.h"

namespace takt::languages::urscript {

namespace {

/// A wrench, force before torque, given at a frame and in its axes, at and in the axes of another one.
/// @param X_FT  pose of the other one in the frame
kinematics::Vector6 seen_from(const Eigen::Isometry3d& X_FT, const std::vector<double>& wrench) {
  const Eigen::Vector3d force(wrench[0], wrench[1], wrench[2]), torque(wrench[3], wrench[4], wrench[5]);
  kinematics::Vector6 seen;
  seen << X_FT.linear().transpose() * force, X_FT.linear().transpose() * (torque - X_FT.translation().cross(force));
  return seen;
}

}  // namespace

void add_pose_functions(Library& library) {
  library.add("pose_trans(p_from, p_from_to)", checked([](const Arguments& a) -> Outcome {
                return Value(to_pose(to_isometry(a.pose(0)) * to_isometry(a.pose(1))));
              }));
  library.add("wrench_trans(T_from_to, w_from)", checked([](const Arguments& a) -> Outcome {
                return to_value(seen_from(to_isometry(a.pose(0)), a.numbers(1, 6)));
              }));
  library.add("pose_inv(p_from)",
              checked([](const Arguments& a) -> Outcome { return Value(to_pose(to_isometry(a.pose(0)).inverse())); }));
  const auto combined = [](const Arguments& a, double sign) -> Outcome {
    const Eigen::Isometry3d from = to_isometry(a.pose(0)), by = to_isometry(a.pose(1));
    Eigen::Isometry3d sum = Eigen::Isometry3d::Identity();
    sum.translation() = from.translation() + sign * by.translation();
    sum.linear() = sign > 0.0 ? (from.linear() * by.linear()).eval() : (from.linear() * by.linear().transpose()).eval();
    return Value(to_pose(sum));
  };
  library.add("pose_add(p_1, p_2)", checked([=](const Arguments& a) { return combined(a, 1.0); }));
  library.add("pose_sub(p_to, p_from)", checked([=](const Arguments& a) { return combined(a, -1.0); }));
  library.add("pose_dist(p_from, p_to)", checked([](const Arguments& a) -> Outcome {
                return Value((to_isometry(a.pose(0)).translation() - to_isometry(a.pose(1)).translation()).norm());
              }));
  library.add("point_dist(p_from, p_to)", checked([](const Arguments& a) -> Outcome {
                return Value((to_isometry(a.pose(0)).translation() - to_isometry(a.pose(1)).translation()).norm());
              }));
  library.add("interpolate_pose(p_from, p_to, alpha)", checked([](const Arguments& a) -> Outcome {
                const Eigen::Isometry3d from = to_isometry(a.pose(0)), to = to_isometry(a.pose(1));
                const double share = a.real(2);
                Eigen::Isometry3d between = Eigen::Isometry3d::Identity();
                between.translation() = from.translation() + share * (to.translation() - from.translation());
                const Eigen::Vector3d turn = motion::log_rotation(from.linear().transpose() * to.linear());
                between.linear() = from.linear() * motion::exp_rotation(share * turn);
                return Value(to_pose(between));
              }));
  library.add("rotvec2rpy(rotation_vector)", checked([](const Arguments& a) -> Outcome {
                const auto v = a.numbers(0, 3);
                const Eigen::Matrix3d R = motion::exp_rotation(Eigen::Vector3d(v[0], v[1], v[2]));
                const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
                return to_list({std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))});
              }));
  library.add("rpy2rotvec(rpy_vector)", checked([](const Arguments& a) -> Outcome {
                const auto v = a.numbers(0, 3);
                const Eigen::Matrix3d R = (Eigen::AngleAxisd(v[2], Eigen::Vector3d::UnitZ()) *
                                           Eigen::AngleAxisd(v[1], Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(v[0], Eigen::Vector3d::UnitX()))
                                              .toRotationMatrix();
                return to_value(motion::log_rotation(R));
              }));
}

}  // namespace takt::languages::urscript
