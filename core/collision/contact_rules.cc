#include "core/collision/contact_rules.h"

#include <algorithm>

namespace takt::collision {

ContactRules::ContactRules(const CellShapes& shapes, const CellState& situation)
    : shapes_(shapes), holders_(situation.holders) {
  const int count = static_cast<int>(shapes.scene.bodies().size());
  for (int body = 0; body < count; ++body) roles_.push_back(role_of(body, situation));
}

ContactRules::Role ContactRules::role_of(int body, const CellState& situation) const {
  const Scene& scene = shapes_.scene;
  const std::string& owner = scene.body(body).owner;
  Role role{.arm = {}, .machine = !shapes_.objects.contains(owner), .known = !situation.unknown.contains(body)};
  for (int at = body; at >= 0;) {
    const Body& one = scene.body(at);
    if (const auto arm = shapes_.arms.find(one.owner); arm != shapes_.arms.end()) {
      role.arm = one.owner;
      role.carried = one.owner != owner;
      role.base = arm->second.is_base;
      return role;
    }
    at = one.root ? situation.state.fixings[static_cast<std::size_t>(at)].parent : one.parent;
  }
  return role;
}

bool ContactRules::holds(int gripper, int object) const {
  const auto holders = holders_.find(object);
  return holders != holders_.end() && holders->second.contains(shapes_.scene.body(gripper).owner);
}

/// Machines are not touched on purpose; furniture, parts (also those that another arm holds), and bases with what is
/// mounted on them are.
bool ContactRules::may_be_touched(int body) const {
  const Role& one = role(body);
  return !one.machine || one.arm.empty() || one.base;
}

bool ContactRules::wants_to_touch(int body, const Touching& touching) const {
  const Role& one = role(body);
  return one.carried && (touching.contains(one.arm) || touching.contains(shapes_.scene.body(body).owner));
}

Contact ContactRules::contact(int a, int b, const Touching& touching) const {
  const Role &one = role(a), &other = role(b);
  if (!one.known || !other.known) return Contact::kIgnored;
  if (one.arm.empty() && other.arm.empty()) return Contact::kIgnored;  // no arm has a part in it
  if (holds(a, b) || holds(b, a)) return Contact::kIgnored;
  if (one.arm == other.arm && one.carried && other.carried) return Contact::kIgnored;  // fixed to each other
  if (shapes_.is_relaxed(shapes_.scene.body(a), shapes_.scene.body(b))) return Contact::kIgnored;
  // What drives stays as high as it is, and all that stands on it.
  if ((a == shapes_.floor && other.base) || (b == shapes_.floor && one.base)) return Contact::kIgnored;
  if (shapes_.couplings.contains(std::minmax(a, b))) return Contact::kSetDown;
  if (one.arm == other.arm && one.base && !(one.machine && other.machine)) return Contact::kIgnored;  // it stands there
  if (one.arm == other.arm) return Contact::kForbidden;
  for (const auto& [who, what] : {std::pair(a, b), std::pair(b, a)}) {
    if (!may_be_touched(what)) continue;
    if (wants_to_touch(who, touching)) return Contact::kMeant;
    if (role(who).carried && !role(who).machine) return Contact::kSetDown;
  }
  return Contact::kForbidden;
}

PairRule rule_for(Contact contact, double overlap) {
  switch (contact) {
    case Contact::kIgnored:
      return {.kind = PairRule::Kind::kIgnored};
    case Contact::kSetDown:
      return {.kind = PairRule::Kind::kTouch, .overlap = overlap, .may_part = true};
    default:
      return {.kind = PairRule::Kind::kApart, .may_part = true};
  }
}

}  // namespace takt::collision
