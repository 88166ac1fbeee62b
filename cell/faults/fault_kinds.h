#pragma once

#include "cell/faults/fault_kind.h"

/// The kinds of faults that takt itself brings; faults.cc lists them. Realtime: setup.
namespace takt::cell {

[[nodiscard]] FaultKind device_fault();
[[nodiscard]] FaultKind emergency_stop_fault();
[[nodiscard]] FaultKind push_fault();
[[nodiscard]] FaultKind release_fault();
[[nodiscard]] FaultKind reset_fault();
[[nodiscard]] FaultKind sensor_fault();
[[nodiscard]] FaultKind stop_fault();
[[nodiscard]] FaultKind tool_changer_fault();
[[nodiscard]] FaultKind torch_fault();

}  // namespace takt::cell
