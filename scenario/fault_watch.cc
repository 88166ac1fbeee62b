#include "scenario/fault_watch.h"

#include <utility>

#include <fmt/format.h>

namespace takt::scenario {

void FaultWatch::look(const ContactLog& contacts, const Where& where, const Note& note) {
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
  std::uint32_t& before = faults_[name];
  if (std::exchange(before, fault) == fault) return;
  if (fault == 0) return note(name, "recovered", "no fault any more");
  std::string text = arm.fault_text(fault);
  if (const auto hardest = contacts.hardest_on(name))
    text += fmt::format("; '{}' pressed '{}' with {:.1f} N at {:.3f} s", hardest->ours, hardest->other, hardest->force,
                        to_seconds(hardest->time));
  note(name, "fault", text);
  constexpr std::size_t kMost = 20;
  const std::string step = where();
  if (told_.size() < kMost)
    told_.push_back(fmt::format("{}: {}{}", name, text, step.empty() ? "" : fmt::format(" in '{}'", step)));
}

}  // namespace takt::scenario
