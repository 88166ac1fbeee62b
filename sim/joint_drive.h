#pragma once

#include "core/kinematics/types.h"
#include "sim/device.h"

namespace takt::sim {

using kinematics::JointVector;

/// Friction and brakes of the joints of an arm: the part of the plant between motor and link.
/// Friction is Coulomb friction, smoothed around standstill so that an explicit step carries it, plus viscous friction.
/// A brake is a stiff spring and damper from the link to where the brake closed, that slips at its holding torque.
/// Thread: one. Realtime: cyclic but for the constructor.
class JointDrives {
 public:
  /// @param inertia  (n) smallest inertia that each joint has to move, kg m^2 or kg, > 0
  /// @param timestep s
  JointDrives(JointVector coulomb, JointVector viscous, const JointVector& inertia, JointVector brake_torque,
              double timestep);

  /// Friction torque that opposes dq; the sign of dq.
  void friction(const JointVector& dq, JointVector& torque) const;

  /// Closes the brakes at q; `torque` is what the joints carry at this moment, so that a joint at rest does not sag.
  void close(const JointVector& q, const JointVector& torque, const JointVector& inertia);
  /// Torque of the closed brakes on the joints; moves the locked position on where a brake slips.
  void brake_torque(const JointVector& q, const JointVector& dq, JointVector& torque);

  void stream(StateStream& state);

 private:
  JointVector coulomb_, viscous_, smoothing_, limit_;
  JointVector locked_, stiffness_, damping_;
};

}  // namespace takt::sim
