#include "scenario/contact_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "core/expression/believed_shapes.h"

namespace takt::scenario {
namespace {

/// Less than this is no contact: what only just touches, N.
constexpr double kTouching = 0.1;
/// Apart for as long: a touch bounces.
constexpr Nanoseconds kApart = 100 * kMillisecond;
/// Before a fault: from the blow to the stop.
constexpr Nanoseconds kLately = 250 * kMillisecond;

/// "gripper" of "gripper/finger_left"; an object is its own.
std::string owner_of(const std::string& body) { return body.substr(0, body.find('/')); }

}  // namespace

ContactLog::ContactLog(BuiltCell& built) : built_(built), names_(built.world->body_names()) {
  if (built.cell.shapes->off.empty()) return;  // the guard lists them
  std::vector<bool> machines;
  for (const std::string& body : names_) machines.push_back(body.find('/') != std::string::npos);
  built.world->list_contacts_of(std::move(machines));
}

std::string ContactLog::name(int body) const {
  const std::string& name = names_[static_cast<std::size_t>(body)];
  return name.empty() ? "floor" : name;
}

void ContactLog::look(std::span<const sim::BodyContact> contacts, const Note& note) {
  for (const sim::BodyContact& contact : contacts)
    if (contact.force >= kTouching) note_contact(contact, note);
  const Nanoseconds now = built_.world->time();
  for (auto& [owners, touch] : touches_) {
    if (!touch.lasts || now - touch.last < kApart) continue;
    touch.lasts = false;
    note("parted", fmt::format("'{}' and '{}' after {:.3f} s, {:.1f} N at most", owners.first, owners.second,
                               to_seconds(touch.last - touch.begin), touch.force));
  }
}

void ContactLog::note_contact(const sim::BodyContact& contact, const Note& note) {
  const Nanoseconds now = built_.world->time();
  const std::string a = name(contact.a), b = name(contact.b);
  std::string first = owner_of(a), second = owner_of(b);
  if (second < first) std::swap(first, second);
  if (first == second) return;
  Touch& touch = touches_[{first, second}];
  if (!touch.lasts) {
    touch = {.begin = now, .lasts = true};
    note("contact", fmt::format("'{}' touches '{}' with {:.1f} N", a, b, contact.force));
  }
  Summary& summary = summaries_.try_emplace({first, second}, Summary{.first = now, .force = 0.0}).first->second;
  summary.force = std::max(summary.force, contact.force);
  touch.last = now;
  touch.force = std::max(touch.force, contact.force);
  if (contact.force < touch.recent_force && now - touch.recent_time <= kLately) return;
  touch.recent_force = contact.force;
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

}  // namespace takt::scenario
