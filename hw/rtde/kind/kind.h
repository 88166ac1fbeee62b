#pragma once

#include <memory>

#include "core/device/driver.h"

namespace takt::rtde {

/// The driver kind "rtde". Realtime: setup.
[[nodiscard]] std::unique_ptr<device::DriverKind> make_kind();

}  // namespace takt::rtde
