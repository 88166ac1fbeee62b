#pragma once

#include <memory>
#include <string>

#include "cell/build/built_cell.h"
#include "cell/build/command_tape.h"
#include "cell/build/faulty_readings.h"
#include "cell/file/description.h"
#include "core/device/signal.h"

namespace takt::cell {

/// Gives the core a canonical input on the simulated terminal or beam of that name.
/// @param may_fail  faults of the scenario can spoil it. Realtime: setup.
template <class T>
device::SignalInput<T>& add_input(const std::string& name, const std::string& unit, Nanoseconds sample_age_max,
                                  bool may_fail, BuiltCell& built) {
  auto backend = built.borrowed<device::SignalInputBackend<T>>(built.world->input(name));
  if (may_fail) backend = built.with_faults<FaultyInput<T>>(name, std::move(backend));
  backend = built.commands->samples().tap<T>(name, std::move(backend));
  device::SignalInputDescription<T> description{.unit = unit, .sample_age_max = sample_age_max};
  return built.core->add(std::make_unique<device::SignalInput<T>>(name, std::move(description), std::move(backend)));
}

/// The simulated terminals of a block, by the names of its model. @param entry  of a scenario that was checked
[[nodiscard]] device::IoTerminals simulated_terminals(const DeviceEntry& entry, const device::IoDescription& io,
                                                      BuiltCell& built);

}  // namespace takt::cell
