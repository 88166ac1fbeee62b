#pragma once

#include <span>

#include <Eigen/Core>

struct mjModel_;
struct mjData_;

/// Springs between bodies as rows of MuJoCo's constraint. MuJoCo makes the rows of an equality that is active; between
/// the halves of a step a law sets them. The equation is that of a contact's normal direction, on both sides
/// (docs/contacts.md, "The law").
namespace takt::sim {

struct RowSpring {
  double stiffness = 0.0;  ///< N/m or Nm/rad
  double damping = 0.0;    ///< N s/m or Nm s/rad
  double mass = 0.0;       ///< kg or kg m^2 that moves against it, about
};

/// The first row of an equality; -1: it has none in this step. Realtime: cyclic.
[[nodiscard]] int row_of_equality(const mjData_& data, int equality);

/// The rate of a row's coordinate: its Jacobian times the velocities. Realtime: cyclic.
[[nodiscard]] double rate_of_row(const mjModel_& model, const mjData_& data, int row);

/// Sets the Jacobian of a row of an equality between two bodies.
/// @param jacobian  (nv) zero but for the joints that move one of the two. Realtime: cyclic.
void set_jacobian(const mjModel_& model, mjData_& data, int row, std::span<const double> jacobian);

/// Gives a row the force of a spring, implicit in the step. Its Jacobian is set. Realtime: cyclic.
void set_spring(const mjModel_& model, mjData_& data, int row, const RowSpring& spring, double stretch);

/// Gives a row an inertia, kg or kg m^2, against changes of its rate, and no other force. Its Jacobian is set.
/// Realtime: cyclic.
void set_inertia(const mjModel_& model, mjData_& data, int row, double inertia);

/// Takes all effect from rows: no Jacobian, no force. Realtime: cyclic.
void silence_rows(const mjModel_& model, mjData_& data, int first, int count);

/// A force and a torque at a point, all in the world; N, Nm, m.
struct RowWrench {
  Eigen::Vector3d force, torque, point;
};

/// Takes the forces out of the six rows of a weld and applies them to its bodies from outside: this on the first, the
/// opposite on the second. Realtime: cyclic.
void take_weld(mjData_& data, int row, int first, int second, const RowWrench& wrench);

}  // namespace takt::sim
