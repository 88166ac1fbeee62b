#pragma once

#include <memory>
#include <vector>

#include "core/device/driver.h"

namespace takt::hw {

/// The kinds of drivers that takt itself brings. Realtime: setup.
[[nodiscard]] std::unique_ptr<device::DriverKind> fri_kind();
[[nodiscard]] std::unique_ptr<device::DriverKind> rtde_kind();
[[nodiscard]] std::unique_ptr<device::DriverKind> cia402_kind();
[[nodiscard]] std::unique_ptr<device::DriverKind> wsg_kind();
[[nodiscard]] std::unique_ptr<device::DriverKind> modbus_kind();

/// Makes all of them known to device::DriverKinds. May be called again. Realtime: setup.
void add_own_drivers();

}  // namespace takt::hw
