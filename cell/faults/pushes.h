#pragma once

#include <vector>

#include <Eigen/Core>

#include "cell/build/built_cell.h"

namespace takt::cell {

/// Forces of people on bodies of the simulation; those on one body add up. Thread: the session's.
class Pushes {
 public:
  explicit Pushes(BuiltCell& built) : built_(built) {}

  /// @param owner  who pushes, once at a time; @param force  at the centre of mass, in the world, N
  void add(const void* owner, int body, const Eigen::Vector3d& force);
  void remove(const void* owner);

 private:
  struct Push {
    const void* owner;
    int body;
    Eigen::Vector3d force;
  };
  void exert(int body);

  BuiltCell& built_;
  std::vector<Push> pushes_;
};

}  // namespace takt::cell
