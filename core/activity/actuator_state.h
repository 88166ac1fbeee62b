#pragma once

#include <optional>
#include <string>

#include "core/device/backend.h"
#include "core/device/seam.h"
#include "core/kinematics/types.h"
#include "core/net/value.h"

namespace takt::activity {

/// What is known of an actuator at one instant, mostly a future one. Nothing: unknown.
struct ActuatorState {
  std::optional<kinematics::JointVector> q, dq, ddq;  ///< of its set point; rad, rad/s, rad/s^2 or the same in m
  std::optional<std::string> mode;                    ///< control mode
  std::optional<device::ToolSetting> tool;            ///< what it carries
  std::optional<net::Wrench> force;                   ///< that it is made to exert, N and Nm in its tool frame

  /// It is at rest at q and exerts nothing.
  [[nodiscard]] static ActuatorState at_rest(const kinematics::JointVector& q) {
    const kinematics::JointVector zero = kinematics::JointVector::Zero(q.size());
    return {.q = q, .dq = zero, .ddq = zero, .mode = std::nullopt, .tool = std::nullopt, .force = net::Wrench{}};
  }
  /// It is known where it is, and that it does not move.
  [[nodiscard]] bool rests() const { return q && dq && ddq && dq->isZero() && ddq->isZero(); }
};

/// The same is known of both, and it is the same.
[[nodiscard]] bool operator==(const ActuatorState& a, const ActuatorState& b);
/// What both agree on; the rest is unknown.
[[nodiscard]] ActuatorState common(const ActuatorState& a, const ActuatorState& b);

}  // namespace takt::activity
