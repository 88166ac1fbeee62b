#pragma once

#include <string>

#include "core/device/backend.h"
#include "sim/model/world_description.h"

namespace takt::sim {

/// What an arm carries, as its URDFs say and as a technician would enter it: all robots and fixed objects mounted on
/// the flange link or on what is fixed to it, directly or one on another, with movable joints at zero. Not what the
/// arm's own URDF holds beyond the flange: that belongs to the chain. In axes of the flange. Realtime: setup.
/// @param robot   name of a robot of the description that has the link `flange_link`
[[nodiscard]] device::PayloadSetting nominal_payload(const WorldDescription& description, const std::string& robot,
                                                     const std::string& flange_link);

}  // namespace takt::sim
