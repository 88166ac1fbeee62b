#pragma once

#include <gtest/gtest.h>

#include "core/rcc/control_core.h"
#include "tests/support/allocation_guard.h"

namespace takt::test {

/// One cycle of the core, which must not allocate.
inline void guarded_step(rcc::ControlCore& core) {
  const AllocationGuard guard;
  core.step();
  const std::size_t allocations = guard.count();
  EXPECT_EQ(allocations, 0u) << "in cycle " << core.cycle() - 1;
}

}  // namespace takt::test
