#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// The socket of a screw. S: its bottom, z out of the screw.
struct ScrewSocket {
  int body = 0;
  double mass = 0.0;     ///< kg, of the screw
  double inertia = 0.0;  ///< kg m^2, the least of the screw
  Pose X_OS = Pose::Identity();
  double radius = 0.0, depth = 0.0;  ///< m
  double head_radius = 0.0;          ///< m, of the part with the socket
};
/// Of all screws of the world. Realtime: setup.
[[nodiscard]] std::vector<ScrewSocket> sockets_of(const mjModel_& model, const WorldDescription& description);

/// The end of a bit seen from a socket.
struct BitInSocket {
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();  ///< m
  bool inside = false;  ///< between a little outside of the mouth and a little beyond the bottom, and along the axis
};
/// @param reach  m, of the bit along the z axis of its body. Realtime: cyclic.
[[nodiscard]] BitInSocket look_into(const ScrewSocket& socket, const mjData_& data, int bit, double reach);
/// How far the cylinders of a bit reach along the z axis of its body, m. Realtime: setup.
[[nodiscard]] double reach_of(const mjModel_& model, int bit);

/// Hexagon keys in hexagon sockets. The shapes in contact are round; what makes a hexagon of them is a spring between
/// bit and screw about the axis of the bit, with the play and the torsional stiffness of a key. It works while the bit
/// is in the socket, whatever force presses it in, and exerts nothing but a torque about that axis.
/// While a bit touches a screw, an inertia between the two keeps the few grams of the screw from moving, within a step,
/// by more than their shapes have play. It opposes changes of their velocity against each other and nothing else.
/// Owned by the thread law; one thread. Figures and limits: docs/threads.md, "The bit in its socket".
class DriveLaw {
 public:
  DriveLaw() = default;
  /// Realtime: setup.
  DriveLaw(const mjModel_& model, const WorldDescription& description);

  /// Between the halves of a step: sets the rows of each bit. Realtime: cyclic.
  void prepare(const mjModel_& model, mjData_& data);
  /// After the solver: applies the torques to the bodies, for sensors (sim/contact/spring_row.h). Realtime: cyclic.
  void sense(mjData_& data) const;
  /// After the positions have changed: which bit is in which socket.
  /// @return true: one has changed, and the constraints of this state must be made again. Realtime: cyclic.
  [[nodiscard]] bool watch(mjModel_& model, mjData_& data);
  /// After stream() has read another state. Realtime: setup.
  void resume(mjModel_& model, mjData_& data) const;
  void stream(StateStream& state);

 private:
  struct Bit {
    int body = 0, equality = 0;
    double reach = 0.0;                ///< m
    std::vector<double> inertia = {};  ///< kg, against the screw of each socket while they touch
    std::int64_t socket = -1;          ///< that it is in; -1: none
    double twist = 0.0;                ///< rad, of the screw against it since then
    std::int64_t touched = -1;         ///< the socket of the screw that it has touched of late; -1: none
    double since = 0.0;                ///< s, since then
  };
  struct Axes;
  [[nodiscard]] std::int64_t socket_around(const mjData_& data, const Bit& bit) const;
  [[nodiscard]] std::int64_t touching(const mjModel_& model, const mjData_& data, const Bit& bit) const;
  /// Of the screw that the constraint is with; -1: none.
  [[nodiscard]] static std::int64_t partner(const Bit& bit) { return bit.socket >= 0 ? bit.socket : bit.touched; }
  [[nodiscard]] Axes axes_of(const mjData_& data, const Bit& bit) const;
  void apply(mjModel_& model, mjData_& data, const Bit& bit) const;
  void set_inertias(const mjModel_& model, mjData_& data, const Bit& bit, int row);
  void set_turn(const mjModel_& model, mjData_& data, Bit& bit, int row);

  std::vector<Bit> bits_;
  std::vector<ScrewSocket> sockets_;
  std::vector<double> jacobians_;  ///< scratch: four of 3 x nv
  Eigen::RowVectorXd row_;         ///< scratch: nv
};

}  // namespace takt::sim
