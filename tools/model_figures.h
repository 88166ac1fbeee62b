#pragma once

#include <memory>

#include "core/device/description.h"
#include "core/device/gripper.h"
#include "tools/cli.h"

namespace takt::tools {

/// The figures of a model as tables, or as one JSON object. `arm` and `gripper` are null for any other kind.
int print_figures(const std::string& name, const std::string& kind, const kinematics::RobotModel& robot,
                  const device::ArmDescription* arm, const device::GripperDescription* gripper, const Common& common);

}  // namespace takt::tools
