#pragma once

#include <memory>

#include "cell/judge/expectation.h"
#include "core/base/object_reader.h"

/// Expectations about grippers and signals. Realtime: setup.
namespace takt::cell {

/// "gripper": what a gripper does at the end.
[[nodiscard]] std::unique_ptr<Expectation> screw_expectation(ObjectReader& reader, const BuiltCell& built);
[[nodiscard]] std::unique_ptr<Expectation> gripper_expectation(ObjectReader& reader, const BuiltCell& built);
/// "signal": what an input or output is at the end, and how often it rose.
[[nodiscard]] std::unique_ptr<Expectation> signal_expectation(ObjectReader& reader, const BuiltCell& built);

}  // namespace takt::cell
