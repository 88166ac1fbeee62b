#pragma once

#include "core/base/diagnostics.h"
#include "sim/machines/arm.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// What the simulated controller of an arm has of the plant: addresses, figures of the joints, its chain and payload.
/// @return it, or what is wrong with the description. Realtime: setup.
[[nodiscard]] Result<ArmPlant> arm_plant(const mjModel_& model, const mjData_& data,
                                         const WorldDescription& description, const SimArmDescription& arm);

}  // namespace takt::sim
