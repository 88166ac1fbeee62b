#pragma once

#include <vector>

#include <Eigen/Geometry>

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// The motion of bodies that fly freely: rigid, six degrees of freedom. An explicit step of the gyroscopic torque adds
/// energy without bound. Here a body turns by the implicit midpoint rule in its own frame, which keeps energy and
/// angular momentum to rounding; its centre of mass goes straight on. What else acts in a step (gravity, contacts,
/// constraints) is added as MuJoCo has solved it. Owned by the world; one thread. Equations: docs/simulation.md, "Free
/// motion". Realtime: cyclic but for the constructor.
class FreeMotion {
 public:
  FreeMotion() = default;
  explicit FreeMotion(const mjModel_& model);

  /// Between the halves of a step: MuJoCo's velocity-dependent forces are replaced by those that lead to the velocity
  /// of free motion at the end of the step.
  void prepare(const mjModel_& model, mjData_& data);
  /// After the step: pose and velocity as the free motion has them, and what has acted beside it.
  void finish(const mjModel_& model, mjData_& data) const;

 private:
  /// A tree of bodies fixed to each other; B: the frame of its free joint, C: its centre of mass.
  struct Flyer {
    int tree = 0, position = 0, velocity = 0;        ///< its number, and addresses of its joint
    double mass = 0.0;                               ///< kg
    Eigen::Vector3d p_BC = Eigen::Vector3d::Zero();  ///< m, in B
    Eigen::Matrix3d I_C = Eigen::Matrix3d::Zero();   ///< kg m^2, in the axes of B
    // Of this step.
    bool flies = false;
    Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();  ///< at its begin
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< free motion, from its begin to its end, in B
    Eigen::Vector3d p_WC = Eigen::Vector3d::Zero(), v_WC = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_free = Eigen::Vector3d::Zero(), w_free = Eigen::Vector3d::Zero();  ///< of B; w in B
  };
  std::vector<Flyer> flyers_;
};

/// Turns a body for a time as it turns if nothing acts on it.
/// @param I        inertia about its centre of mass, in its own axes
/// @param[in,out] w  angular velocity in its own axes, rad/s
/// @return by how much it has turned, in the axes of the begin. Realtime: cyclic.
Eigen::Quaterniond turn_freely(const Eigen::Matrix3d& I, Eigen::Vector3d& w, double duration);

}  // namespace takt::sim
