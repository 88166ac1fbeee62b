#pragma once

#include <string>

#include "core/command/command.h"
#include "core/net/description.h"
#include "core/operations/table/step.h"

namespace takt::operations {

/// Verifies a net as LOAD will, so that what is wrong with it is known before anything moves. Realtime: setup.
void rehearse_net(const net::NetDescription& description, const Rehearsal& rehearsal, const std::string& pointer,
                  Diagnostics& diagnostics);

/// The same for the net of a command; or all that is wrong with that, at the step.
/// @param title  of the net
void rehearse_command(const command::Command& command, const std::string& title, const Rehearsal& rehearsal,
                      const std::string& pointer, Diagnostics& diagnostics);

}  // namespace takt::operations
