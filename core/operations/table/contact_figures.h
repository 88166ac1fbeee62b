#pragma once

#include <string>

#include "core/command/actions/online_action.h"

namespace takt::operations {

/// What counts as contact for a force that is wanted, and how late the sensor is that says so: the same for everything
/// that presses. Sets these figures of `control`, whose force is set.
/// @param sensor  in the cell; of an unknown one nothing is known of its delay
/// Realtime: setup.
void set_contact_figures(command::ForceControlParameters& control, const expression::Cell& cell,
                         const std::string& sensor);

}  // namespace takt::operations
