#pragma once

#include <memory>
#include <string>

#include "cell/judge/expectation.h"
#include "cell/judge/step_window.h"
#include "core/base/object_reader.h"

/// Expectations about where things truly are. Realtime: setup.
namespace takt::cell {

/// "estimate": a fitted pose is near the truth.
[[nodiscard]] std::unique_ptr<Expectation> estimate_expectation(ObjectReader& reader, const BuiltCell& built);
/// "belief": a frame or an object is at the end where the program believes it to be.
[[nodiscard]] std::unique_ptr<Expectation> belief_expectation(ObjectReader& reader, const BuiltCell& built);
/// "object_pose": an object is near a pose, at the end or in each cycle of a step.
[[nodiscard]] std::unique_ptr<Expectation> object_pose_expectation(ObjectReader& reader, const BuiltCell& built,
                                                                   const StepNames& steps);
/// "tool_pose": the same of the tool of an arm, or of a base.
[[nodiscard]] std::unique_ptr<Expectation> tool_pose_expectation(ObjectReader& reader, const BuiltCell& built,
                                                                 const StepNames& steps);

/// Key "arm": with a single one there is nothing to choose.
[[nodiscard]] std::string read_arm_name(ObjectReader& reader, const BuiltCell& built);

}  // namespace takt::cell
