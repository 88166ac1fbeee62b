#include "cell/run/fault_watch.h"

#include <utility>

#include <fmt/format.h>

namespace takt::cell {

void FaultWatch::look(const ContactLog& contacts, const Where& where, const Note& note) {
  tell_trips(contacts, where, note);
  for (const auto& [name, arm] : built_.cell.arms) look_at(name, *arm.device, contacts, where, note);
  if (built_.emergency_stop == nullptr) return;
  const bool latched = built_.emergency_stop->pressed();
  if (std::exchange(latched_, latched) == latched) return;
  note(built_.emergency_stop->name(), latched ? "pressed" : "released",
       fmt::format("category {}", static_cast<int>(built_.emergency_stop->category())));
}

void FaultWatch::look_at(const std::string& name, const device::Arm& arm, const ContactLog& contacts,
                         const Where& where, const Note& note) {
  if (!arm.has_sample()) return;
  const std::uint32_t fault = arm.sample().fault;
  Seen& seen = arms_[name];
  const bool was_ready = std::exchange(seen.was_ready, seen.was_ready || arm.ready());
  if (std::exchange(seen.fault, fault) == fault) return;
  // On the way up a controller tells its states as causes why it is not ready: none of them is an error.
  if (!was_ready) return note(name, "starting", fault == 0 ? "no cause any more" : arm.fault_text(fault));
  if (fault == 0) return note(name, "recovered", "no fault any more");
  tell(name, "fault", arm.fault_text(fault), contacts, where, note);
}

void FaultWatch::hear(std::span<const rcc::Event> events) {
  for (const rcc::Event& event : events) {
    if (event.kind != rcc::Event::Kind::kStopped || event.cause.code != net::Cause::Code::kGuard) continue;
    trip_ = event.cause.text;
    trips_.fetch_add(1, std::memory_order_release);
  }
}

/// What a program makes of a force ends at the guard if it is too much for the arm. It brakes now.
void FaultWatch::tell_trips(const ContactLog& contacts, const Where& where, const Note& note) {
  const std::uint32_t trips = trips_.load(std::memory_order_acquire);
  if (std::exchange(trips_told_, trips) == trips) return;
  for (const auto& [name, arm] : built_.cell.arms)
    if (arm.device->phase() == device::Arm::Phase::kBraking)
      return tell(name, "guard", fmt::format("refused a set point: {}", trip_.view()), contacts, where, note);
}

void FaultWatch::tell(const std::string& name, std::string_view what, std::string text, const ContactLog& contacts,
                      const Where& where, const Note& note) {
  if (const auto hardest = contacts.hardest_on(name))
    text += fmt::format("; '{}' pressed '{}' with {:.1f} N at {:.3f} s", hardest->ours, hardest->other, hardest->force,
                        to_seconds(hardest->time));
  note(name, what, text);
  constexpr std::size_t kMost = 20;
  const std::string step = where();
  if (told_.size() < kMost)
    told_.push_back(fmt::format("{}: {}{}", name, text, step.empty() ? "" : fmt::format(" in '{}'", step)));
}

}  // namespace takt::cell
