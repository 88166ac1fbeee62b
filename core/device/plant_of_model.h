#pragma once

#include "core/base/diagnostics.h"
#include "core/device/description.h"
#include "core/device/plant_file.h"

namespace takt::device {

/// The plant of a model that has been read before. Realtime: setup.
[[nodiscard]] Result<PlantDescription> read_plant(const ModelDescription& model);

}  // namespace takt::device
