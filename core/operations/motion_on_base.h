#pragma once

#include <memory>

#include "core/operations/operation_command.h"

namespace takt::activity {

/// "lin" with "base_to": the tool goes on a straight line in the room while the base that carries the arm drives to a
/// goal of its own; both on one clock. Realtime: setup.
[[nodiscard]] std::unique_ptr<OperationCommand> read_motion_on_base(const OperationSource& source);

}  // namespace takt::activity
