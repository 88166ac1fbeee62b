#pragma once

#include "sim/machines/arm_law.h"

namespace takt::sim {

/// The integral part of a position controller: it learns the friction that its model of the joints lacks
/// (docs/simulation.md, "Friction that the model lacks"). What acts on a joint beside motor and model is estimated from
/// how the joint accelerates; of it that part is compensated that friction can be: at most a share of the modelled
/// friction at the measured speed, faded out where a joint creeps, so nothing at a standstill. What pushes at a
/// contact, and a wrong payload, pass by. It reads the torque that the motors gave, so it does not wind up at their
/// limits. Thread: one. Realtime: cyclic but for the constructor.
class FrictionObserver {
 public:
  /// @param rate   (n) 1/s, how fast the estimate follows; 0: that joint has none
  /// @param share  of the modelled friction that the unknown part may be at most
  FrictionObserver(JointVector rate, double share);

  [[nodiscard]] bool active() const { return active_; }
  /// Of the step from the last velocity to this one, rad/s^2; 0 in the first step after a reset.
  [[nodiscard]] JointVector acceleration(const JointVector& dq, double h) { return observer_.acceleration(dq, h); }
  /// @param needed  M a + C dq + g for a = acceleration(), with rotors and the friction that the model knows, Nm
  /// @param torque  that the motors gave in this step, Nm
  void update(const JointVector& needed, const JointVector& torque, double h);
  /// What is added to the torque of the motors, Nm.
  /// @param friction  modelled, at the measured speed, Nm; @param dq  that speed, rad/s
  [[nodiscard]] JointVector compensation(const JointVector& friction, const JointVector& dq) const;
  /// Forgets everything: the brakes are closed, or another law computes.
  void reset() { observer_.reset(); }
  /// An observer of no joint has no state.
  void stream(StateStream& state);

 private:
  JointVector rate_;
  double share_;
  bool active_;
  ExternalTorqueObserver observer_;
};

}  // namespace takt::sim
