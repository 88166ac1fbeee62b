// Where the arm is, kinematics, and what hangs on the flange.
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
  add_tool(library, c);
}

}  // namespace takt::hw::rtde
