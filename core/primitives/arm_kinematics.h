#pragma once

#include <string>

#include "core/device/arm.h"
#include "core/kinematics/chain.h"
#include "core/net/setup.h"

namespace takt::primitives {

/// The frame that a primitive speaks of, seen from the flange: parameter "tool", default the arm's tool at load.
inline net::Frame tool_parameter(net::Setup& setup, const device::Arm* arm) {
  const net::Frame fallback = arm != nullptr ? arm->tool().X_FT : net::Frame::Identity();
  return setup.parameter<net::Frame>(
      "tool", fallback, {.unit = "m", .doc = "pose of the frame T in the flange; default: the arm's tool"});
}

/// A diagnostic if the arm lacks kinematics. Realtime: setup.
inline Diagnostics need_chain(const device::Arm* arm, bool need_inverse) {
  Diagnostics diagnostics;
  const bool missing = arm != nullptr &&
                       (arm->description().chain == nullptr || (need_inverse && arm->description().inverse == nullptr));
  if (missing)
    diagnostics.error(Code::kUnknownName, "/device", "arm '" + arm->name() + "' has no inverse kinematics of this kind",
                      "Name another arm");
  return diagnostics;
}

/// What the linear rows of a Jacobian are divided by where lengths and angles have to be compared.
inline double length_parameter(net::Setup& setup) {
  return setup.parameter<net::Real>(
      "length", 0.5, {.unit = "m", .doc = "length that counts as much as one radian", .range = "(0,inf)"});
}

/// Where the tool of an arm stands and how it moves with the joints: parameters "device" and "tool".
struct ArmKinematics {
  explicit ArmKinematics(net::Setup& setup)
      : arm(setup.device<device::Arm>("device", device::Arm::kKind, "whose kinematics")),
        X_FT(tool_parameter(setup, arm)) {}

  [[nodiscard]] Diagnostics check() const { return need_chain(arm, false); }

  /// @return false if these are not positions of this arm's joints. Realtime: cyclic.
  bool look(const net::In<net::JointArray>& q) {
    return !q.null() && q->size == arm->joint_count() && look(kinematics::JointVector(q->map()));
  }
  bool look(const kinematics::JointVector& q) {
    if (q.size() != arm->joint_count()) return false;
    net::Frame X_BF;
    arm->description().chain->jacobian(q, X_BF, J_BT);
    const net::Vector p_FT_B = X_BF.linear() * X_FT.translation();
    for (Eigen::Index i = 0; i < J_BT.cols(); ++i) J_BT.col(i).head<3>() += J_BT.col(i).tail<3>().cross(p_FT_B);
    X_BT = X_BF * X_FT;
    return true;
  }

  device::Arm* arm;
  net::Frame X_FT;
  net::Frame X_BT = net::Frame::Identity();  ///< at the newest look
  kinematics::Jacobian J_BT;                 ///< of T's origin, in the axes of B, linear rows first
};

}  // namespace takt::primitives
