#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/collision/cell_shapes.h"
#include "core/collision/motion_check.h"

/// Which contacts steps mean: the same rules for rehearsal and run (docs/world.md, "Collisions in the rehearsal").
namespace takt::collision {

/// A cell at one time, as it is believed to be.
struct CellState {
  State state;
  std::map<int, std::set<std::string>> holders = {};  ///< by body of an object: the grippers that hold it
  std::set<int> unknown = {};                         ///< bodies of objects of which nobody knows where they are
};

/// Devices that mean to touch something: an arm whose motion is guarded (its tool), a gripper that moves its fingers.
using Touching = std::set<std::string, std::less<>>;

/// What a contact of two bodies would be.
enum class Contact {
  kIgnored,    ///< not looked at
  kForbidden,  ///< a collision
  kSetDown,    ///< a part that is held may stand on this; a tool changer and a tool side may meet
  kMeant,      ///< a step that runs wants to touch
};

/// Answers for one situation. Thread: any.
class ContactRules {
 public:
  /// The shapes must outlive it. Realtime: setup.
  ContactRules(const CellShapes& shapes, const CellState& situation);

  /// What it would be if two bodies touched. Bodies that one joint connects, or that are fixed to each other, are not
  /// asked for (Scene::never_meet). Realtime: setup.
  [[nodiscard]] Contact contact(int a, int b, const Touching& touching) const;
  /// The arm or base that moves a body, itself or as something that it carries; empty: none.
  [[nodiscard]] const std::string& arm_of(int body) const { return roles_[static_cast<std::size_t>(body)].arm; }

 private:
  struct Role {
    std::string arm;
    bool carried = false;  ///< by the arm's flange: a tool, a sensor, a held part
    bool machine = false;  ///< no object
    bool known = true;
    bool base = false;  ///< `arm` is a base
  };
  [[nodiscard]] const Role& role(int body) const { return roles_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] Role role_of(int body, const CellState& situation) const;
  [[nodiscard]] bool holds(int gripper, int object) const;
  [[nodiscard]] bool may_be_touched(int body) const;
  [[nodiscard]] bool wants_to_touch(int body, const Touching& touching) const;

  const CellShapes& shapes_;
  std::map<int, std::set<std::string>> holders_;
  std::vector<Role> roles_;  ///< by body
};

/// What check_motion() and check_state() are to do with a pair. @param overlap  m: of a part that is set down
[[nodiscard]] PairRule rule_for(Contact contact, double overlap);

/// By how much a held part may sink into what it is set down on, and anything into anything at the start, m.
inline constexpr double kSetDownOverlap = 1e-3;

}  // namespace takt::collision
