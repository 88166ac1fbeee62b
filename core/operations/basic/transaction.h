#pragma once

#include "core/operations/table/operation.h"

/// "transaction": commands in one real-time context, with handlers for events. Realtime: setup.
namespace takt::operations {

[[nodiscard]] Operation transaction_operation();

}  // namespace takt::operations
