#pragma once

#include <string>

#include "core/device/arm.h"
#include "core/operations/table/operation.h"

/// "control_mode": brings an arm into a control mode while no net holds it. Realtime: setup.
namespace takt::operations {

struct ControlModeParameters {
  std::string arm = {};  ///< empty: the only one
  device::ControlMode mode = device::ControlMode::kPosition;
  std::string name = {}, pointer = {};  ///< for people; in its file
};
[[nodiscard]] const ParameterTable<ControlModeParameters>& control_mode_parameters();
[[nodiscard]] Operation control_mode_operation();

}  // namespace takt::operations
