#pragma once

#include <memory>

#include "core/operations/table/operation.h"

namespace takt::operations {

/// An operation that is a command, as a step of a program: one net, through the mapping of the command layer. Names of
/// commands and raised states that are not there are diagnostics. Realtime: setup.
[[nodiscard]] std::unique_ptr<Step> step_of_command(const OperationSource& source);

}  // namespace takt::operations
