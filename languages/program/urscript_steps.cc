// From commands of a program to steps of operations, in SI units or those of the keys.
#include "languages/program/urscript_steps.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using urscript::ForceCommand;
using urscript::LastingCommand;
using urscript::MotionCommand;

// Accelerations count as shares of the language's own defaults, since operations have shares of the arm's limits.
constexpr double kFullJointAcceleration = 1.4;  // rad/s^2
constexpr double kFullToolAcceleration = 1.2;   // m/s^2
constexpr double kLeastShare = 0.001;
constexpr double kShortestBlend = 1e-5;   // m
constexpr double kFastestApproach = 0.1;  // m/s, of press and force_offset

Json list_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// One motion as a step.
class MotionStep {
 public:
  MotionStep(const MotionCommand& motion, bool turns, const UrscriptMap& map, const expression::Cell& cell)
      : motion_(motion), turns_(turns), map_(map), cell_(cell) {}

  Json make() {
    constexpr std::string_view kWords[] = {"ptp", "lin", "circ"};
    Json step{{"do", kWords[static_cast<std::size_t>(motion_.kind)]},
              {"name", script_step_name(motion_.at, motion_.word)},
              {"arm", map_.arm}};
    set_tool(step);
    step["to"] = goal(motion_.goal);
    if (motion_.kind == MotionCommand::Kind::kArc) step["via"] = goal(motion_.via);
    if (motion_.tangential) step["orientation"] = "tangential";
    set_dynamics(step);
    if (motion_.radius >= kShortestBlend) step["blend_m"] = motion_.radius;
    if (motion_.force) set_force(step);
    return step;
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  [[nodiscard]] bool of_joints() const { return motion_.kind == MotionCommand::Kind::kJoints; }

  /// The path of a tool centre point is that of one that the cell has; where the tool does not turn any will do.
  void set_tool(Json& step) {
    auto tool = map_.find_tool(cell_, motion_.X_FT);
    if (!tool) {
      tool = map_.find_tool(cell_, map_.usual_tool(cell_));
      if (!of_joints() && turns_)
        problem_ = "set_tcp() is no tool centre point of the cell, and the tool turns: declare it in the cell";
    }
    if (!tool) return;
    X_FT_ = tool->X_FT;
    if (!tool->tool.empty()) step["tool"] = tool->tool;
    if (!tool->tcp.empty()) step["tcp"] = tool->tcp;
  }

  [[nodiscard]] Json goal(const urscript::MotionGoal& goal) const {
    if (goal.q.size() == 0) return pose_goal(goal.X_BF * X_FT_, map_.arm);
    Json joints = Json::array();
    for (const double q : goal.q) joints.push_back(q * 180.0 / std::numbers::pi);
    return {{"joints_deg", std::move(joints)}};
  }

  void set_dynamics(Json& step) const {
    const double full = of_joints() ? kFullJointAcceleration : kFullToolAcceleration;
    if (of_joints()) {
      const device::Arm* const device = cell_.arms.find(map_.arm)->second.device;
      const double fastest = device == nullptr ? 0.0 : device->description().limits.velocity.maxCoeff();
      if (motion_.velocity < fastest) step["speed"] = std::max(motion_.velocity / fastest, kLeastShare);
    } else {
      step["velocity_m_s"] = motion_.velocity;
    }
    if (motion_.acceleration < full) step["acceleration"] = std::max(motion_.acceleration / full, kLeastShare);
  }

  void set_force(Json& step) {
    if (of_joints() || turns_) {
      problem_ = of_joints() ? "movej() while a force is held: only lines and arcs can hold one"
                             : "a force along a fixed axis while the tool turns";
      return;
    }
    const ForceCommand& force = *motion_.force;
    const Eigen::Matrix3d R_BT = (motion_.goal.X_BF * X_FT_).linear();
    const double velocity = std::min(force.velocity, kFastestApproach);
    Json offset{{"direction", list_of(R_BT.transpose() * force.direction)},
                {"reach_m", map_.travel},
                {"force_N", force.force},
                {"approach_m_s", velocity},
                {"velocity_max_m_s", velocity}};
    if (!map_.sensor.empty()) offset["sensor"] = map_.sensor;
    step["force_offset"] = std::move(offset);
  }

  const MotionCommand& motion_;
  bool turns_;
  const UrscriptMap& map_;
  const expression::Cell& cell_;
  Eigen::Isometry3d X_FT_ = Eigen::Isometry3d::Identity();
  std::string problem_;
};

}  // namespace

std::string script_step_name(const TextLocation& at, const std::string& word) {
  return fmt::format("{}: {}", at.line, word);
}

Json motion_step(const MotionCommand& motion, bool turns, const UrscriptMap& map, const expression::Cell& cell,
                 std::string& problem) {
  MotionStep maker(motion, turns, map, cell);
  Json step = maker.make();
  problem = maker.problem();
  return problem.empty() ? step : Json();
}

Json lasting_step(const LastingCommand& command, const UrscriptMap& map) {
  constexpr double kFastest = 1.0, kFastestTurn_deg = 180.0, kLongest = 3600.0;  // m/s, deg/s, s
  constexpr std::string_view kNames[] = {"servo", "speedl", "freedrive_mode", "force_mode"};
  const std::string name = script_step_name(command.at, std::string(kNames[static_cast<std::size_t>(command.kind)]));
  switch (command.kind) {
    case LastingCommand::Kind::kServo:
      return {{"do", "follow"},
              {"name", name},
              {"arm", map.arm},
              {"channel", map.pose_channel},
              {"in", map.arm},
              {"linear_max_m_s", kFastest},
              {"angular_max_deg_s", kFastestTurn_deg},
              {"seconds", kLongest}};
    case LastingCommand::Kind::kSpeed:
      return {{"do", "jog"},
              {"name", name},
              {"arm", map.arm},
              {"channel", map.velocity_channel},
              {"in", map.arm},
              {"while", {{"channel", map.enable_channel}}},
              {"linear_max_m_s", kFastest},
              {"angular_max_deg_s", kFastestTurn_deg},
              {"seconds", kLongest}};
    case LastingCommand::Kind::kFreedrive:
      return {{"do", "freedrive"}, {"name", name}, {"arm", map.arm}, {"seconds", kLongest}};
    case LastingCommand::Kind::kForce:
      break;
  }
  Json step{{"do", "press"},
            {"name", name},
            {"arm", map.arm},
            {"direction", list_of(command.force.direction)},
            {"in", map.arm},
            {"force_N", command.force.force},
            {"approach_m_s", std::min(command.force.velocity, kFastestApproach)},
            {"travel_m", map.travel},
            {"seconds", kLongest}};
  if (!map.sensor.empty()) step["sensor"] = map.sensor;
  return step;
}

}  // namespace takt::languages
