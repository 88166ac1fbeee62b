#include "core/activity/actuator_state.h"

namespace takt::activity {
namespace {

template <class T, class Same>
std::optional<T> agreed(const std::optional<T>& a, const std::optional<T>& b, Same same) {
  return a && b && same(*a, *b) ? a : std::nullopt;
}

bool same_joints(const kinematics::JointVector& a, const kinematics::JointVector& b) {
  return a.size() == b.size() && (a.array() == b.array()).all();
}

bool same_tool(const device::ToolSetting& a, const device::ToolSetting& b) {
  return a.payload.mass == b.payload.mass && a.X_FT.matrix() == b.X_FT.matrix();
}

bool same_force(const net::Wrench& a, const net::Wrench& b) { return a.force == b.force && a.torque == b.torque; }

}  // namespace

ActuatorState common(const ActuatorState& a, const ActuatorState& b) {
  return {.q = agreed(a.q, b.q, same_joints),
          .dq = agreed(a.dq, b.dq, same_joints),
          .ddq = agreed(a.ddq, b.ddq, same_joints),
          .mode = agreed(a.mode, b.mode, [](const auto& x, const auto& y) { return x == y; }),
          .tool = agreed(a.tool, b.tool, same_tool),
          .force = agreed(a.force, b.force, same_force)};
}

bool operator==(const ActuatorState& a, const ActuatorState& b) {
  const auto alike = [](const auto& one, const auto& other, auto same) {
    return one.has_value() == other.has_value() && (!one || same(*one, *other));
  };
  return alike(a.q, b.q, same_joints) && alike(a.dq, b.dq, same_joints) && alike(a.ddq, b.ddq, same_joints) &&
         a.mode == b.mode && alike(a.tool, b.tool, same_tool) && alike(a.force, b.force, same_force);
}

}  // namespace takt::activity
