#pragma once

#include <memory>

#include "core/device/description.h"
#include "tools/cli.h"

namespace takt::tools {

/// The figures of a model as tables, or as one JSON object. `arm` is null for any other kind.
int print_figures(const std::string& name, const std::string& kind, const kinematics::RobotModel& robot,
                  const device::ArmDescription* arm, const Common& common);

}  // namespace takt::tools
