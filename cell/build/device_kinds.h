#pragma once

#include <memory>
#include <vector>

#include "cell/build/device_kind.h"

namespace takt::cell {

/// The kinds that takt itself brings, each from a file of its own. Realtime: setup.
[[nodiscard]] std::unique_ptr<DeviceKind> arm_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> base_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> conveyor_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> force_torque_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> gripper_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> io_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> light_barrier_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> range_finder_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> screwdriver_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> tool_changer_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> tool_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> tool_side_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> torch_kind();
[[nodiscard]] std::unique_ptr<DeviceKind> vacuum_cup_kind();

/// All of them: the one place that lists them.
[[nodiscard]] std::vector<std::unique_ptr<DeviceKind>> own_device_kinds();

}  // namespace takt::cell
