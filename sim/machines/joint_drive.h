#pragma once

#include "core/kinematics/types.h"
#include "sim/model/device.h"

namespace takt::sim {

using kinematics::JointVector;

/// Friction and brakes of the joints of an arm: the part of the plant between motor and link.
/// Friction is Coulomb friction, smoothed around standstill so that an explicit step carries it, plus viscous friction.
/// A brake is a stiff spring and damper from the link to where the brake closed, that slips at its holding torque. What
/// stands may be held by its friction alone (stick()): the same spring, which slips at the Coulomb friction.
/// Thread: one. Realtime: cyclic but for the constructor.
class JointDrives {
 public:
  /// @param inertia  (n) smallest inertia that each joint has to move, kg m^2 or kg, > 0
  /// @param timestep s
  JointDrives(JointVector coulomb, JointVector viscous, const JointVector& inertia, JointVector brake_torque,
              double timestep);

  /// Friction torque that opposes dq; the sign of dq.
  void friction(const JointVector& dq, JointVector& torque) const;

  [[nodiscard]] const JointVector& coulomb() const { return coulomb_; }

  /// Closes the brakes at q; `torque` is what the joints carry at this moment, so that a joint at rest does not sag.
  void close(const JointVector& q, const JointVector& torque, const JointVector& inertia);
  /// From now on static friction holds the joints at q.
  void stick(const JointVector& q, const JointVector& inertia);
  /// Torque on the joints of what holds them, brakes or static friction; moves the locked position on where it slips.
  void holding_torque(const JointVector& q, const JointVector& dq, JointVector& torque);

  void stream(StateStream& state);

 private:
  void lock(const JointVector& q, const JointVector& torque, const JointVector& inertia, const JointVector& limit);

  JointVector coulomb_, viscous_, smoothing_, brake_;
  JointVector locked_, stiffness_, damping_, limit_;  // of what holds
};

}  // namespace takt::sim
