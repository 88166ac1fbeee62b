#include "cell/run/contact_guard.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/expression/believed_shapes.h"

namespace takt::cell {
namespace {

/// Less than this is no contact: what only just touches, N.
constexpr double kLeastForce = 0.1;
/// What was allowed stays so until the bodies have been apart for as long: a touch bounces.
constexpr Nanoseconds kParted = 100 * kMillisecond;
/// A blow has passed its peak when it has been less for so long.
constexpr Nanoseconds kBlowPassed = 50 * kMillisecond;
/// From the first touch: no blow is waited for longer.
constexpr Nanoseconds kLongestBlow = 500 * kMillisecond;

}  // namespace

ContactGuard::ContactGuard(BuiltCell& built) : built_(built), names_(built.world->body_names()) {
  const collision::CellShapes& shapes = *built.cell.shapes;
  if (!shapes.off.empty()) return;
  for (const std::string& name : names_) {
    const int number = name.empty() ? shapes.floor : shapes.scene.find(name);
    numbers_.push_back(number);
    machines_.push_back(number >= 0 && !shapes.objects.contains(shapes.scene.body(number).owner));
  }
}

void ContactGuard::look(std::span<const sim::BodyContact> contacts, const TouchingNow& touching) {
  std::optional<collision::Touching> now;
  if (!built_.cell.shapes->off.empty()) return;
  for (const sim::BodyContact& contact : contacts) {
    const Pair pair{contact.a, contact.b};
    if (!machines_[static_cast<std::size_t>(pair.first)] && !machines_[static_cast<std::size_t>(pair.second)]) continue;
    if (contact.magnitude < kLeastForce || is_known(pair)) continue;
    if (!now) now = all_touching(touching);
    if (is_allowed(pair, *now)) {
      in_contact_[pair] = built_.world->time();
    } else {
      note_crash(pair, contact.magnitude);
    }
  }
}

void ContactGuard::note_crash(const Pair& pair, double force) {
  const Nanoseconds time = built_.world->time();
  auto crash = std::ranges::find(crashes_, pair, &Crash::pair);
  if (crash == crashes_.end())
    crash = crashes_.insert(crash, {.pair = pair, .begin = time, .peak_time = time, .first = force, .peak = force});
  if (force <= crash->peak) return;
  crash->peak = force;
  crash->peak_time = time;
}

bool ContactGuard::is_over() const {
  const Nanoseconds time = built_.world->time();
  return std::ranges::all_of(crashes_, [time](const Crash& crash) {
    return time - crash.peak_time >= kBlowPassed || time - crash.begin >= kLongestBlow;
  });
}

Diagnostics ContactGuard::faults() const {
  Diagnostics faults;
  for (const Crash& crash : crashes_) faults.add(fault(crash));
  return faults;
}

/// Compliant arms too.
collision::Touching ContactGuard::all_touching(const TouchingNow& touching) const {
  collision::Touching all = touching ? touching() : collision::Touching();
  for (const auto& [name, arm] : built_.cell.arms)
    if (arm.device->mode() != device::ControlMode::kPosition) all.insert(name);
  return all;
}

/// What was allowed is so as long as it lasts.
bool ContactGuard::is_known(const Pair& pair) {
  const auto known = in_contact_.find(pair);
  if (known == in_contact_.end()) return false;
  const Nanoseconds time = built_.world->time();
  const bool lasts = time - known->second < kParted;
  if (lasts) known->second = time;
  return lasts;
}

bool ContactGuard::is_allowed(const Pair& pair, const collision::Touching& touching) const {
  const int a = numbers_[static_cast<std::size_t>(pair.first)], b = numbers_[static_cast<std::size_t>(pair.second)];
  if (a < 0 || b < 0) return true;  // what only the simulation has
  const collision::CellShapes& shapes = *built_.cell.shapes;
  if (shapes.scene.never_meet(a, b)) return true;
  const collision::CellState situation = believed_situation(built_.cell, {}, {});
  return collision::ContactRules(shapes, situation).contact(a, b, touching) != collision::Contact::kForbidden;
}

Diagnostic ContactGuard::fault(const Crash& crash) const {
  const auto name = [this](int body) {
    const std::string& own = names_[static_cast<std::size_t>(body)];
    return own.empty() ? built_.cell.shapes->scene.body(built_.cell.shapes->floor).name : own;
  };
  const std::string later =
      crash.peak > crash.first ? fmt::format("; {:.1f} N at most, at {:.3f} s", crash.peak, to_seconds(crash.peak_time))
                               : "";
  return {.severity = Severity::kError,
          .code = Code::kUnexpectedContact,
          .file = {},
          .pointer = {},
          .message =
              fmt::format("'{}' touches '{}' with {:.1f} N at {:.3f} s, and no step means to{}", name(crash.pair.first),
                          name(crash.pair.second), crash.first, to_seconds(crash.begin), later),
          .hint = "Use a guarded motion where a touch is meant, or add an entry to 'allow' in 'collisions'"};
}

}  // namespace takt::cell
