#pragma once

#include <memory>

#include "core/operations/command/operation_command.h"
#include "core/operations/motion/motion.h"

/// Planned motions as commands of a transaction. Realtime: setup.
namespace takt::operations {

/// @param source  of the motion, for diagnostics
[[nodiscard]] std::unique_ptr<OperationCommand> motion_command(MotionTask motion, const OperationSource& source);

}  // namespace takt::operations
