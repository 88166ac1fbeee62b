#pragma once

#include <utility>

#include "core/device/driver.h"
#include "hw/emulators/rtde/io.h"
#include "hw/rtde/terminals.h"

namespace takt::hw::rtde {

/// Joins the terminals of an emulated controller with the machine behind them: lamps, barriers. One thread.
class WiredTerminals {
 public:
  /// @param io  of a block that refuse_terminals() accepts @param machine  all terminals of that block
  WiredTerminals(const device::IoDescription& io, device::IoTerminals machine)
      : map_(io), machine_(std::move(machine)) {}

  /// A terminal whose machine gives no sample keeps its value. Realtime: cyclic.
  void read_inputs(Terminals& terminals) const;
  void write_outputs(const Terminals& terminals) const;

 private:
  TerminalMap map_;
  device::IoTerminals machine_;
};

}  // namespace takt::hw::rtde
