#pragma once

#include <span>
#include <vector>

#include "cell/build/built_cell.h"

namespace takt::cell {

/// A contact of a machine.
struct ContactForce {
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();  ///< m in world
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< N in world, that acts on the machine
};

/// Contacts as forces on machines, for films and recordings: per pair of bodies the greatest since take() was called
/// last; where two machines touch, on the second. Beside them those between objects and with the floor. Thread: one at
/// a time. Realtime: setup.
class ContactForces {
 public:
  /// Machines are devices: not the world, and no objects, with a model or without.
  explicit ContactForces(const BuiltCell& built);

  /// @param contacts  what World::take_contacts() gave
  void add(std::span<const sim::BodyContact> contacts);
  /// Since take() was called last, of pairs in which there is no machine; the greatest first. What hardly touches, less
  /// than 0.5 N, is left out.
  [[nodiscard]] std::vector<sim::BodyContact> between_objects() const;
  /// The greatest first; what hardly touches, less than 0.5 N, is left out.
  [[nodiscard]] std::vector<ContactForce> take();

 private:
  std::vector<bool> machines_;  ///< by number of the body
  std::vector<sim::BodyContact> contacts_;
};

}  // namespace takt::cell
