#include "cell/faults/emergency_circuit.h"

namespace takt::cell {

void EmergencyCircuit::press(device::StopCategory category, Nanoseconds brakes_after) {
  if (built_.emergency_stop == nullptr) return;
  built_.emergency_stop->set_category(category);
  built_.emergency_stop->set_healthy(false);
  const Nanoseconds now = built_.core->time();
  if (category == device::StopCategory::kBrakes) brakes_at_ = now;
  if (category == device::StopCategory::kStopThenBrakes) brakes_at_ = now + brakes_after;
}

void EmergencyCircuit::reset() {
  if (built_.emergency_stop == nullptr) return;
  brakes_at_.reset();
  built_.emergency_stop->set_healthy(true);
  reset_pending_ = true;
}

void EmergencyCircuit::begin_cycle() {
  if (built_.emergency_stop == nullptr) return;
  opened_ = opened_ || !built_.emergency_stop->latched();
  // A button gives an edge: up in one cycle, down in the next.
  built_.emergency_stop->set_reset(reset_pending_ && built_.core->cycle() > 0);
  if (built_.core->cycle() > 0) reset_pending_ = false;
}

void EmergencyCircuit::end_cycle() {
  if (!brakes_at_ || *brakes_at_ > built_.core->time()) return;
  brakes_at_.reset();
  for (const auto& [name, arm] : built_.cell.arms) built_.world->arm(name)->stop(device::StopCategory::kBrakes);
}

bool EmergencyCircuit::latched() const { return built_.emergency_stop != nullptr && !opened_; }

}  // namespace takt::cell
