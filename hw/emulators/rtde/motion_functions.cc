// Motions, as programs ask for them.
#include <fmt/format.h>

#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

namespace {

using urscript::Failed;
using urscript::Library;
using urscript::Outcome;
using urscript::Value;
using urscript::Wait;

Failed not_yours() { return {"another thread is already controlling the robot"}; }

/// Until the controller's time has come.
Wait until_time(Controller& c, double seconds, Value result = {}) {
  const Nanoseconds end = c.time() + static_cast<Nanoseconds>(seconds * 1e9) - c.cycle() / 2;
  return [&c, end, result]() -> std::optional<Value> {
    if (c.time() < end) return std::nullopt;
    return result;
  };
}
Wait until_done(Controller& c) {
  return [&c]() -> std::optional<Value> {
    if (!c.motion().move_done()) return std::nullopt;
    return Value();
  };
}
/// Until the joints are told to stand, which is two frames after the newest position does.
Wait until_rest(Controller& c) {
  return [&c]() -> std::optional<Value> {
    const bool told = c.told_next().dq.cwiseAbs().maxCoeff() < 1e-6;
    if (!c.motion().at_rest() || !told) return std::nullopt;
    return Value();
  };
}

/// Joint positions, or the nearest ones for a pose.
JointVector goal_joints(Controller& c, const Arguments& a) {
  const auto pose = a[0].pose();
  if (!pose) return a.joints(0);
  const auto q = c.motion().kinematics().nearest_solution(to_isometry(*pose), c.motion().q());
  if (!q) throw BadArgument{"the pose is out of reach"};
  return *q;
}
/// A pose, or that of joint positions.
Eigen::Isometry3d goal_pose(Controller& c, const Arguments& a, std::size_t i) {
  if (a[i].pose()) return to_isometry(a.pose(i));
  return c.motion().kinematics().X_BT(a.joints(i));
}

/// Begins a move; what cannot be is a protective stop for moves of the tool, as on a real controller.
Outcome begin_move(Controller& c, const Arguments& a, const MoveRequest& request) {
  if (!c.take_motion(a.thread())) return not_yours();
  if (const auto problem = c.motion().move(request)) {
    if (request.kind == MoveRequest::Kind::kJoints) return Failed{*problem};
    c.protective_stop(*problem, 204, 3);
    return until_done(c);
  }
  return until_done(c);
}

MoveRequest request_for(const Arguments& a, MoveRequest::Kind kind, std::size_t first) {
  MoveRequest request{.kind = kind, .q_goal = {}};
  request.acceleration = a.real(first);
  request.velocity = a.real(first + 1);
  if (request.acceleration <= 0.0 || request.velocity <= 0.0)
    throw BadArgument{"velocity and acceleration must be above 0"};
  return request;
}

Outcome move_joints(Controller& c, const Arguments& a) {
  MoveRequest request = request_for(a, MoveRequest::Kind::kJoints, 1);
  request.q_goal = goal_joints(c, a);
  request.time = a.real(3);
  request.blend_radius = a.real(4);
  const auto& limits = c.motion().kinematics().arm().limits;
  for (int i = 0; i < request.q_goal.size(); ++i)
    if (request.q_goal[i] < limits.lower[i] || request.q_goal[i] > limits.upper[i])
      throw BadArgument{fmt::format("joint {} to {:.3f} rad is outside of its range", i, request.q_goal[i])};
  return begin_move(c, a, request);
}

Outcome move_line(Controller& c, const Arguments& a, bool has_time) {
  MoveRequest request = request_for(a, MoveRequest::Kind::kLine, 1);
  request.X_BT_goal = goal_pose(c, a, 0);
  request.time = has_time ? a.real(3) : 0.0;
  request.blend_radius = a.real(has_time ? 4 : 3);
  return begin_move(c, a, request);
}

Outcome move_arc(Controller& c, const Arguments& a) {
  MoveRequest request = request_for(a, MoveRequest::Kind::kArc, 2);
  request.X_BT_via = goal_pose(c, a, 0);
  request.X_BT_goal = goal_pose(c, a, 1);
  request.blend_radius = a.real(4);
  return begin_move(c, a, request);
}

/// What takes `seconds`, at least a frame; 0: a frame.
Outcome lasting(Controller& c, double seconds) { return until_time(c, std::max(seconds, to_seconds(c.cycle()))); }

Outcome servo_joints(Controller& c, const Arguments& a) {
  if (!c.take_motion(a.thread())) return not_yours();
  c.motion().servo(goal_joints(c, a), a.real(4), a.real(5));
  return lasting(c, a.real(3));
}

/// Towards the pose, as fast as it says; on the way of the tool from where it is now.
Outcome servo_tool(Controller& c, const Arguments& a) {
  if (!c.take_motion(a.thread())) return not_yours();
  const Eigen::Isometry3d goal = goal_pose(c, a, 0), here = c.motion().kinematics().X_BT(c.motion().q());
  const double acceleration = a.real(1), speed = a.real(2);
  const urscript::Pose turn = to_pose(Eigen::Isometry3d((goal.linear() * here.linear().transpose()).eval()));
  Vector6 way;
  way << goal.translation() - here.translation(), Eigen::Vector3d(turn[3], turn[4], turn[5]);
  const double length = std::max(way.head<3>().norm(), 1e-9);
  // Not faster than it can still brake.
  const double wanted = std::min({std::abs(speed), std::sqrt(2.0 * std::max(acceleration, 1e-3) * length),
                                  length / (4.0 * to_seconds(c.cycle()))});
  c.motion().speed_tool(way * (wanted / length), acceleration);
  return lasting(c, 0.0);
}

/// Until the speed is reached, or for the time that is given. The speed stays until the next command, or until the
/// thread ends.
Outcome keep_speed(Controller& c, double seconds, double until_reached) {
  return lasting(c, seconds > 0.0 ? seconds : until_reached);
}

Outcome speed_joints(Controller& c, const Arguments& a) {
  if (!c.take_motion(a.thread())) return not_yours();
  const JointVector goal = a.joints(0);
  const double acceleration = std::max(a.real(1), 1e-3);
  const double needed = (goal - c.motion().dq()).cwiseAbs().maxCoeff() / acceleration;
  c.motion().speed_joints(goal, acceleration);
  return keep_speed(c, a.real(2), needed);
}

Outcome speed_tool(Controller& c, const Arguments& a) {
  if (!c.take_motion(a.thread())) return not_yours();
  const auto numbers = a.numbers(0, 6);
  const Vector6 goal = Eigen::Map<const Vector6>(numbers.data());
  const double acceleration = std::max(a.real(1), 1e-3);
  const ToolKinematics& tool = c.motion().kinematics();
  const double change = (goal - tool.twist(c.motion().q(), c.motion().dq())).head<3>().norm();
  c.motion().speed_tool(goal, acceleration);
  return keep_speed(c, a.real(2), change / acceleration);
}

Outcome stop(Controller& c, const Arguments& a, bool tool) {
  if (!c.take_motion(a.thread())) return not_yours();
  const double deceleration = a.real(0);
  if (deceleration <= 0.0) throw BadArgument{"the deceleration must be above 0"};
  if (tool) {
    c.motion().stop_tool(deceleration);
  } else {
    c.motion().stop(deceleration);
  }
  return until_rest(c);
}

}  // namespace

void add_motion_functions(Library& library, Controller& c) {
  const auto add = [&](std::string_view signature, auto run) {
    library.add(signature, checked([&c, run](const Arguments& a) -> Outcome { return run(c, a); }));
  };
  add("movej(q, a=1.4, v=1.05, t=0, r=0)", move_joints);
  add("optimovej(q, a=1.4, v=1.05, r=0)", [](Controller& k, const Arguments& a) {
    MoveRequest request = request_for(a, MoveRequest::Kind::kJoints, 1);
    request.q_goal = goal_joints(k, a);
    request.blend_radius = a.real(3);
    return begin_move(k, a, request);
  });
  add("movel(pose, a=1.2, v=0.25, t=0, r=0)", [](Controller& k, const Arguments& a) { return move_line(k, a, true); });
  add("optimovel(pose, a=1.2, v=0.25, r=0)", [](Controller& k, const Arguments& a) { return move_line(k, a, false); });
  add("movep(pose, a=1.2, v=0.25, r=0)", [](Controller& k, const Arguments& a) { return move_line(k, a, false); });
  add("movec(pose_via, pose_to, a=1.2, v=0.25, r=0, mode=0)", move_arc);
  add("servoj(q, a=0, v=0, t=0.008, lookahead_time=0.1, gain=300)", servo_joints);
  add("servoc(pose, a=1.2, v=0.25, r=0)", servo_tool);
  add("speedj(qd, a=1.4, t=0)", speed_joints);
  add("speedl(xd, a=1.2, t=0, aRot=0)", speed_tool);
  add("stopj(a=2)", [](Controller& k, const Arguments& a) { return stop(k, a, false); });
  add("stopl(a=3, aRot=0)", [](Controller& k, const Arguments& a) { return stop(k, a, true); });
  add("sync()", [](Controller& k, const Arguments&) { return lasting(k, 0.0); });
  add("sleep(t)", [](Controller& k, const Arguments& a) { return lasting(k, a.real(0)); });
  add("get_steptime()", [](Controller& k, const Arguments&) -> Outcome { return Value(to_seconds(k.cycle())); });
  add("is_steady()",
      [](Controller& k, const Arguments&) -> Outcome { return Value(k.motion().at_rest() && k.motion().move_done()); });
  add("protective_stop()", [](Controller& k, const Arguments&) -> Outcome {
    k.protective_stop("protective stop by a program");
    return Value();
  });
}

}  // namespace takt::hw::rtde
