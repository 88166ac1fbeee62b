#include "scenario/faults.h"

#include <cstddef>
#include <vector>

namespace takt::scenario {
void add_faults(const FaultList& faults, BuiltCell& built, Diagnostics& diagnostics) {
  for (const auto& fault : faults) fault->add_to(built, diagnostics);
}

bool Faults::latched() const { return context_.built.emergency_stop != nullptr && !opened_; }

void Faults::apply(const Note& note) {
  context_.now = context_.built.core->time();
  context_.note = &note;
  update_button();
  for (; next_ < entries_.size() && entries_[next_]->at <= context_.now; ++next_) begin(*entries_[next_]);
  end_what_is_over();
  close_brakes();
}

/// A button gives an edge: up in one cycle, down in the next.
void Faults::update_button() {
  device::EmergencyStop* button = context_.built.emergency_stop;
  if (button == nullptr) return;
  opened_ = opened_ || !button->latched();
  const bool runs = context_.built.core->cycle() > 0;
  button->set_reset(context_.button.reset_pending && runs);
  if (runs) context_.button.reset_pending = false;
}

void Faults::begin(const Fault& fault) {
  if (fault.duration) {
    for (std::size_t i = context_.active.size(); i-- > 0;) {
      if (!fault.replaces(*context_.active[i])) continue;
      context_.active.erase(context_.active.begin() + static_cast<std::ptrdiff_t>(i));
      until_.erase(until_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    context_.active.push_back(&fault);
    until_.push_back(context_.now + *fault.duration);
  }
  fault.begin(context_);
}

/// All that are over are gone before the first of them is told: what lasts adds up without them.
void Faults::end_what_is_over() {
  std::vector<const Fault*> over;
  for (std::size_t i = 0; i < until_.size();) {
    if (until_[i] > context_.now) {
      ++i;
      continue;
    }
    over.push_back(context_.active[i]);
    context_.active.erase(context_.active.begin() + static_cast<std::ptrdiff_t>(i));
    until_.erase(until_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  for (const Fault* fault : over) fault->end(context_);
}

void Faults::close_brakes() {
  auto& at = context_.button.brakes_at;
  if (!at || *at > context_.now) return;
  at.reset();
  for (const auto& [name, arm] : context_.built.cell.arms)
    context_.built.world->arm(name)->stop(device::StopCategory::kBrakes);
}

}  // namespace takt::scenario
