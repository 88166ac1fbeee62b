#include "cell/judge/contact_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "core/expression/believed_shapes.h"

namespace takt::cell {
namespace {

/// Less than this is no contact: what only just touches, N.
constexpr double kTouching = 0.1;
/// Apart for as long: a touch bounces.
constexpr Nanoseconds kApart = 100 * kMillisecond;
/// From the start of the run: what touches by then stood there. A gap of 2 mm closes in as long.
constexpr Nanoseconds kSettling = 20 * kMillisecond;
/// Before a fault: from the blow to the stop.
constexpr Nanoseconds kLately = 250 * kMillisecond;

constexpr std::string_view kFloor = "floor";

/// "gripper" of "gripper/finger_left"; an object is its own.
std::string owner_of(const std::string& body) { return body.substr(0, body.find('/')); }

}  // namespace

ContactLog::ContactLog(BuiltCell& built) : built_(built), names_(built.world->body_names()) {
  built.world->list_contacts_of(std::vector<bool>(names_.size(), true));
}

std::string ContactLog::name(int body) const {
  const std::string& name = names_[static_cast<std::size_t>(body)];
  return name.empty() ? std::string(kFloor) : name;
}

void ContactLog::look(std::span<const sim::BodyContact> contacts, const Note& note) {
  for (const sim::BodyContact& contact : contacts) note_contact(contact, note);
  const Nanoseconds now = built_.world->time();
  for (auto& [owners, touch] : touches_) {
    if (!touch.lasts || now - touch.last < kApart) continue;
    touch.lasts = false;
    note("parted", fmt::format("'{}' and '{}' after {:.3f} s, {:.1f} N at most", owners.first, owners.second,
                               to_seconds(touch.last - touch.begin), touch.force));
  }
  std::erase_if(standing_, [now](const auto& pair) { return now - pair.second >= kApart; });
}

/// An object or the floor: no machine.
bool ContactLog::lies_about(const std::string& owner) const {
  return owner == kFloor || built_.cell.objects.contains(owner);
}

/// Two that lie about, since the run has begun.
bool ContactLog::stands(const Owners& owners) {
  const Nanoseconds now = built_.world->time();
  const auto known = standing_.find(owners);
  const bool begins = now <= kSettling && lies_about(owners.first) && lies_about(owners.second);
  if (known == standing_.end() && !begins) return false;
  standing_[owners] = now;
  return true;
}

void ContactLog::note_contact(const sim::BodyContact& contact, const Note& note) {
  const Nanoseconds now = built_.world->time();
  const std::string a = name(contact.a), b = name(contact.b);
  std::string first = owner_of(a), second = owner_of(b);
  if (second < first) std::swap(first, second);
  if (first == second && !built_.cell.arms.contains(first)) return;
  if (stands({first, second}) || contact.magnitude < kTouching) return;
  Touch& touch = touches_[{first, second}];
  if (!touch.lasts) {
    touch = {.begin = now, .lasts = true};
    note("contact", fmt::format("'{}' touches '{}' with {:.1f} N", a, b, contact.magnitude));
  }
  Summary& summary = summaries_.try_emplace({first, second}, Summary{.first = now, .force = 0.0}).first->second;
  summary.force = std::max(summary.force, contact.magnitude);
  touch.last = now;
  touch.force = std::max(touch.force, contact.magnitude);
  if (contact.magnitude < touch.recent_force && now - touch.recent_time <= kLately) return;
  touch.recent_force = contact.magnitude;
  touch.recent_time = now;
  touch.recent = {contact.a, contact.b};
}

bool ContactLog::rides(int body, std::string_view device) const {
  const mjModel& model = *built_.world->physics_model();
  for (; body > 0; body = model.body_parentid[body])
    if (owner_of(names_[static_cast<std::size_t>(body)]) == device) return true;
  return false;
}

std::optional<ContactLog::Hardest> ContactLog::hardest_on(std::string_view device) const {
  std::optional<Hardest> hardest;
  for (const auto& [owners, touch] : touches_) {
    if (built_.world->time() - touch.recent_time > kLately) continue;
    const auto& [a, b] = touch.recent;
    const bool ours = rides(a, device);
    if ((!ours && !rides(b, device)) || (hardest && touch.recent_force <= hardest->force)) continue;
    hardest = Hardest{.ours = name(ours ? a : b),
                      .other = name(ours ? b : a),
                      .force = touch.recent_force,
                      .time = touch.recent_time};
  }
  return hardest;
}

}  // namespace takt::cell
