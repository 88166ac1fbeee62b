#include "cell/judge/contact_forces.h"

#include <algorithm>
#include <functional>

namespace takt::cell {
namespace {

constexpr double kHardlyTouching = 0.5;  ///< N

}  // namespace

ContactForces::ContactForces(const BuiltCell& built) {
  for (const std::string& name : built.world->body_names()) {
    const std::size_t slash = name.find('/');
    machines_.push_back(slash != name.npos && !built.cell.objects.contains(name.substr(0, slash)));
  }
}

void ContactForces::add(std::span<const sim::BodyContact> contacts) {
  for (const sim::BodyContact& contact : contacts) {
    const auto known = std::ranges::find_if(
        contacts_, [&](const sim::BodyContact& one) { return one.a == contact.a && one.b == contact.b; });
    if (known == contacts_.end()) {
      contacts_.push_back(contact);
    } else if (known->force < contact.force) {
      *known = contact;
    }
  }
}

std::vector<sim::BodyContact> ContactForces::between_objects() const {
  std::vector<sim::BodyContact> between;
  for (const sim::BodyContact& contact : contacts_) {
    const bool machine =
        machines_[static_cast<std::size_t>(contact.a)] || machines_[static_cast<std::size_t>(contact.b)];
    if (contact.force >= kHardlyTouching && !machine) between.push_back(contact);
  }
  std::ranges::stable_sort(between, std::greater{}, &sim::BodyContact::force);
  return between;
}

std::vector<ContactForce> ContactForces::take() {
  std::vector<ContactForce> forces;
  for (const sim::BodyContact& contact : contacts_) {
    const bool on_first = machines_[static_cast<std::size_t>(contact.a)];
    const bool on_second = machines_[static_cast<std::size_t>(contact.b)];
    if (contact.force < kHardlyTouching || (!on_first && !on_second)) continue;
    forces.push_back({contact.point_W, on_second ? contact.force_W : Eigen::Vector3d(-contact.force_W)});
  }
  contacts_.clear();
  std::ranges::stable_sort(forces, std::greater{}, [](const ContactForce& one) { return one.force_W.norm(); });
  return forces;
}

}  // namespace takt::cell
