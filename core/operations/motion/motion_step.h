#pragma once

#include <memory>

#include "core/operations/motion/motion.h"
#include "core/operations/table/step.h"

namespace takt::operations {

/// A planned motion as a step of a program: guarded if it has a condition, blended into the motion after it if it asks
/// for that. Realtime: setup.
[[nodiscard]] std::unique_ptr<Step> motion_step(MotionTask motion);

}  // namespace takt::operations
