#pragma once

#include <memory>

#include "cell/judge/expectation.h"
#include "cell/judge/step_window.h"
#include "core/base/object_reader.h"

/// Expectations about two arms. Realtime: setup.
namespace takt::cell {

/// "relative_pose": the tool of one arm truly stays where it was to that of the other, from one step to another.
/// @param steps  names of the program's steps; nothing: nobody knows them
[[nodiscard]] std::unique_ptr<Expectation> relative_pose_expectation(ObjectReader& reader, const BuiltCell& built,
                                                                     const StepNames& steps);

}  // namespace takt::cell
