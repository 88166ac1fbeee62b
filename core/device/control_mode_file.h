#pragma once

#include "core/base/object_reader.h"
#include "core/device/control_mode.h"

namespace takt::device {

/// Reads "modes", "mode_changes" and "impedance" of the object "control" of an arm's device file. What is wrong goes to
/// the reader's diagnostics. Realtime: setup.
/// @param joint_count  0 where the chain could not be read
void read_control_modes(ObjectReader& control, int joint_count, ControlModes& modes, ImpedanceDescription& impedance);

}  // namespace takt::device
