#pragma once

#include "core/base/diagnostics.h"
#include "record/recording.h"
#include "scenario/description.h"

namespace takt::scenario {

/// The scenario that a recording carries, with the seed of its run.
/// @return diagnostics: there is no scenario, it is not valid, the recorded seed is no whole number. Realtime: setup.
[[nodiscard]] Result<Description> recorded_scenario(const record::Recording& recording);

}  // namespace takt::scenario
