#pragma once

#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/kinematics/chain.h"
#include "core/motion/limits.h"
#include "core/motion/path_clock.h"
#include "core/motion/time_law.h"

namespace takt::motion {

/// What the motors of an arm can do along a path, and what a time law over it asks of them. With the path's derivatives
/// q', q'' by s, rigid bodies and rotors need
///
///     tau = m s'' + c s'^2 + d s' + g      m = (M + B) q',  c = (M + B) q'' + C(q, q') q',  d = damping q',
///
/// and Coulomb friction on top. These four are computed at nodes and interpolated between them, so any number of laws
/// can be judged without the robot (Bobrow, Dubowsky, Gibson 1985 have this form). A law may use the same share of
/// what gravity and friction leave as of an acceleration limit; the path clock gets the rest (docs/motion.md).
/// Joints without a torque limit are not looked at. Realtime: setup, deterministic.
class TorqueProfile {
 public:
  /// Keeps references to its arguments.
  TorqueProfile(const kinematics::Chain& chain, const DriveLoad& load) : chain_(chain), load_(load) {}

  /// The next node: s does not fall; a node may stand twice where pieces meet. `first`, `second`: of q by s.
  void add(double s, const JointVector& q, const JointVector& first, const JointVector& second);

  /// A diagnostic at `pointer` if some joint cannot carry arm and load: where, what it needs, what it has.
  [[nodiscard]] Diagnostics overloads(const std::string& pointer) const;

  /// By how much a law must be stretched so that it just keeps its share (below 1: it could be shrunk), and where.
  struct Need {
    double stretch = 0.0;
    double s = 0.0;
  };
  /// @param share  of what gravity and friction leave
  [[nodiscard]] Need need(const TimeLaw& law, double share) const;
  /// The fastest clock under which law and clock keep what the motors have; its stop table knows no jerk.
  [[nodiscard]] ClockBounds clock(const TimeLaw& law) const;

 private:
  struct Node {
    double s;
    JointVector inertial, centrifugal, viscous, gravity;
  };
  /// Asks visit(joint, s, room, first, second, viscous) at every instant of the law: what is left of the limit beside
  /// gravity and dry friction, and what the law asks for, all Nm or N; `first` is by the rate of change of a clock.
  template <class Visit>
  void look(const TimeLaw& law, Visit visit) const;
  [[nodiscard]] double room(int joint, double gravity) const;
  [[nodiscard]] StopTable stop_table(const TimeLaw& law) const;

  const kinematics::Chain& chain_;
  const DriveLoad& load_;
  std::vector<Node> nodes_;
};

}  // namespace takt::motion
