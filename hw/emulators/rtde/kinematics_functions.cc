// Where the arm is, kinematics, and what hangs on the flange.
#include "core/motion/rotation_vector.h"
#include "hw/emulators/rtde/arguments.h"
#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

namespace {

using urscript::Library;
using urscript::Outcome;
using urscript::Pose;
using urscript::Value;

const FieldValue& field(const Controller& c, std::string_view name) { return c.fields()[output_fields().at(name)]; }

/// The kinematics with the tool that a call names, or the one that is set.
ToolKinematics with_tool(Controller& c, const Arguments& a, std::size_t i) {
  ToolKinematics tool = c.motion().kinematics();
  if (!a.none(i) && a[i].number() == std::nullopt) tool.set_tool(to_isometry(a.pose(i)));
  return tool;
}

std::optional<JointVector> solution(Controller& c, const Arguments& a) {
  const JointVector near = a.none(1) || a[1].number() ? c.motion().q() : a.joints(1);
  return with_tool(c, a, 4).nearest_solution(to_isometry(a.pose(0)), near);
}

void add_state(Library& library, Controller& c) {
  const auto joints = [&](std::string_view signature, std::string_view name) {
    library.add(signature, [&c, name](const urscript::Call&) -> Outcome { return to_value(field(c, name)); });
  };
  joints("get_actual_joint_positions()", "actual_q");
  joints("get_joint_positions()", "actual_q");
  joints("get_actual_joint_speeds()", "actual_qd");
  joints("get_target_joint_positions()", "target_q");
  joints("get_target_joint_speeds()", "target_qd");
  joints("get_target_joint_accelerations()", "target_qdd");
  joints("get_joint_torques()", "target_moment");
  joints("get_actual_tcp_speed()", "actual_TCP_speed");
  joints("get_target_tcp_speed()", "target_TCP_speed");
  joints("get_actual_joint_positions_history(steps=0)", "actual_q");
  joints("get_joint_temperatures()", "joint_temperatures");
  const auto pose = [&](std::string_view signature, std::string_view name) {
    library.add(signature, [&c, name](const urscript::Call&) -> Outcome { return Value(Pose(field(c, name))); });
  };
  pose("get_actual_tcp_pose()", "actual_TCP_pose");
  pose("get_target_tcp_pose()", "target_TCP_pose");
  pose("get_target_waypoint()", "target_TCP_pose");
  pose("get_tcp_offset()", "tcp_offset");
  library.add("get_actual_tool_flange_pose()", [&c](const urscript::Call&) -> Outcome {
    return Value(to_pose(c.motion().kinematics().X_BF(c.plant().q)));
  });
  library.add("get_joint_temp(j)", checked([&c](const Arguments& a) -> Outcome {
                return Value(field(c, "joint_temperatures")[static_cast<std::size_t>(a.integer(0, 0, 5))]);
              }));
  library.add("get_tool_accelerometer_reading()", [&c](const urscript::Call&) -> Outcome {
    const FieldValue& measured = field(c, "actual_tool_accelerometer");
    return urscript::to_list({measured[0], measured[1], measured[2]});
  });
  library.add("get_controller_temp()", [](const urscript::Call&) -> Outcome { return Value(30.0); });
  library.add("get_tool_current()", [](const urscript::Call&) -> Outcome { return Value(0.0); });
}

void add_kinematics(Library& library, Controller& c) {
  library.add("get_forward_kin(q=None, tcp=None)", checked([&c](const Arguments& a) -> Outcome {
                const JointVector q = a.none(0) ? c.motion().q() : a.joints(0);
                return Value(to_pose(with_tool(c, a, 1).X_BT(q)));
              }));
  library.add("get_inverse_kin(x, qnear=None, maxPositionError=1e-10, maxOrientationError=1e-10, tcp=None)",
              checked([&c](const Arguments& a) -> Outcome {
                const auto q = solution(c, a);
                if (!q) throw BadArgument{"the pose is out of reach"};
                return to_value(*q);
              }));
  library.add(
      "get_inverse_kin_has_solution(pose, qnear=None, maxPositionError=1e-10, maxOrientationError=1e-10, tcp=None)",
      checked([&c](const Arguments& a) -> Outcome { return Value(solution(c, a).has_value()); }));
  library.add("is_within_safety_limits(pose)", checked([&c](const Arguments& a) -> Outcome {
                if (a[0].pose()) return Value(solution(c, a).has_value());
                const JointVector q = a.joints(0);
                const auto& limits = c.motion().kinematics().arm().limits;
                return Value((q - limits.lower).minCoeff() >= 0.0 && (limits.upper - q).minCoeff() >= 0.0);
              }));
}

/// A wrench, force before torque, given at a frame and in its axes, at and in the axes of another one.
/// @param X_FT  pose of the other one in the frame
Vector6 seen_from(const Eigen::Isometry3d& X_FT, const std::vector<double>& wrench) {
  const Eigen::Vector3d force(wrench[0], wrench[1], wrench[2]), torque(wrench[3], wrench[4], wrench[5]);
  Vector6 seen;
  seen << X_FT.linear().transpose() * force, X_FT.linear().transpose() * (torque - X_FT.translation().cross(force));
  return seen;
}

void add_poses(Library& library) {
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
                return urscript::to_list({std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))});
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

void set_payload(Controller& c, const Arguments& a) {
  const double mass = a.real(0);
  if (mass < 0.0) throw BadArgument{"a mass must not be below 0 kg"};
  c.settings().payload = mass;
  if (!a.none(1)) {
    const auto cog = a.numbers(1, 3);
    c.settings().payload_cog = Eigen::Vector3d(cog[0], cog[1], cog[2]);
  }
  if (!a.none(2)) std::ranges::copy(a.numbers(2, 6), c.settings().payload_inertia.begin());
}

void add_tool(Library& library, Controller& c) {
  library.add("set_tcp(pose, tcp_name='')", checked([&c](const Arguments& a) -> Outcome {
                c.motion().kinematics().set_tool(to_isometry(a.pose(0)));
                return Value();
              }));
  for (const char* signature :
       {"set_payload(m|mass, cog|CoG=None)", "set_target_payload(m|mass, cog=None, inertia=None, transition_time=0)"})
    library.add(signature, checked([&c](const Arguments& a) -> Outcome {
                  set_payload(c, a);
                  return Value();
                }));
  library.add("set_payload_mass(m|mass)", checked([&c](const Arguments& a) -> Outcome {
                set_payload(c, a);
                return Value();
              }));
  library.add("set_payload_cog(cog|CoG)", checked([&c](const Arguments& a) -> Outcome {
                const auto cog = a.numbers(0, 3);
                c.settings().payload_cog = Eigen::Vector3d(cog[0], cog[1], cog[2]);
                return Value();
              }));
  library.add("set_gravity(d)", checked([](const Arguments& a) -> Outcome {
                (void)a.numbers(0, 3);
                return Value();
              }));
  for (const char* signature : {"get_target_payload()", "get_target_payload_mass()"})
    library.add(signature, [&c](const urscript::Call&) -> Outcome { return Value(c.settings().payload); });
  library.add("get_target_payload_cog()",
              [&c](const urscript::Call&) -> Outcome { return to_value(c.settings().payload_cog); });
  library.add("get_target_payload_inertia()",
              [&c](const urscript::Call&) -> Outcome { return to_value(c.settings().payload_inertia); });
}

}  // namespace

void add_kinematics_functions(Library& library, Controller& c) {
  add_state(library, c);
  add_kinematics(library, c);
  add_poses(library);
  add_tool(library, c);
}

}  // namespace takt::hw::rtde
