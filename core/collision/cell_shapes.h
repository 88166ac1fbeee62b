#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/collision/scene.h"

namespace takt::collision {

/// Two bodies that the cell's file takes out of the check, and why. A name is that of a device or object (all its
/// bodies) or of one body ("arm/link_3").
struct Relaxation {
  std::string a, b, reason;
};

/// The solids of a cell with what its file says about their check. Built once, then read only.
struct CellShapes {
  /// An arm or a base: what a program calls by its name.
  struct Mechanism {
    std::vector<int> joints;  ///< numbers in the scene, in the order of the device's joints
    int flange = -1;          ///< body that carries tools and what they hold
    bool is_base = false;     ///< it drives: what it carries stands on it
  };

  Scene scene;
  double margin = 1e-3;  ///< m: nearer than this counts as a collision
  std::string off = {};  ///< why nothing is checked; empty: it is
  std::vector<Relaxation> relaxed = {};
  std::set<std::string, std::less<>> objects = {};                     ///< names; everything else is a machine
  std::set<std::string, std::less<>> free_objects = {};                ///< of these: that arms may carry
  std::map<std::string, Mechanism, std::less<>> arms = {};             ///< by device
  std::map<std::string, std::vector<int>, std::less<>> grippers = {};  ///< joints of the fingers, each half the width
  int floor = -1;  ///< body of the ground, an object; -1: the cell has none
  /// Bodies that are made to meet, the smaller number first: a tool changer and a tool side that fits.
  std::set<std::pair<int, int>> couplings = {};

  /// The ground below z = 0 as one more body, "floor", or "world/floor" where the cell has something of that name.
  /// Realtime: setup.
  void add_floor();
  [[nodiscard]] bool is_relaxed(const Body& a, const Body& b) const;
  /// All names that a Relaxation may use. Realtime: setup.
  [[nodiscard]] std::vector<std::string> names() const;
};

}  // namespace takt::collision
