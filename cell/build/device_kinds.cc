#include "cell/build/device_kinds.h"

namespace takt::cell {

std::vector<std::unique_ptr<DeviceKind>> own_device_kinds() {
  std::vector<std::unique_ptr<DeviceKind>> kinds;
  for (const auto make : {arm_kind, base_kind, conveyor_kind, force_torque_kind, gripper_kind, io_kind,
                          light_barrier_kind, range_finder_kind, screwdriver_kind, tool_changer_kind, tool_kind,
                          tool_side_kind, torch_kind, vacuum_cup_kind}) {
    kinds.push_back(make());
  }
  return kinds;
}

}  // namespace takt::cell
