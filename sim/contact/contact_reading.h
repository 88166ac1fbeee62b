#pragma once

#include <Eigen/Core>

namespace takt::sim {

/// What touches between two sides: see World::watch_contact. The truth of the simulation: expectations only (row D6).
struct ContactReading {
  double force = 0.0;  ///< N, length of the sum of all contact forces between the sides, last physics step
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< N, that side A exerts on side B, last physics step
  double max_force = 0.0;                             ///< N, largest of all physics steps so far
  /// N, of the touches that push one way, last physics step: what opposing touches squeeze with does not cancel.
  double pressing = 0.0;
  double max_pressing = 0.0;  ///< N, largest of all physics steps so far
  int contacts = 0;           ///< contact points in the last physics step
};

/// Two bodies that touch each other, and how hard at most.
struct BodyContact {
  int a = 0, b = 0;    ///< numbers of the bodies, a below b; see World::body
  double force = 0.0;  ///< N, length of the sum of their contact forces in a physics step
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< N in world, that sum: what a exerts on b
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();  ///< m in world, mean of their contact points, by force
  double magnitude = 0.0;  ///< N, greatest sum of the lengths of their contact forces: what cancels counts
};

}  // namespace takt::sim
