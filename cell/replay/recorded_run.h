#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cell/file/description.h"
#include "core/base/diagnostics.h"
#include "record/recording.h"

namespace takt::cell {

/// The scenario that a recording carries, with the seed of its run, or with another one, and with changes.
/// @return diagnostics: there is no scenario, it is not valid, the recorded seed is no whole number. Realtime: setup.
[[nodiscard]] Result<Description> recorded_scenario(const record::Recording& recording,
                                                    const std::vector<Override>& overrides = {},
                                                    std::optional<std::uint64_t> seed = {});

/// Name of the step at which the recorded program was entered (run --from); empty: its beginning. Realtime: setup.
[[nodiscard]] std::string recorded_entry(const record::Recording& recording);

}  // namespace takt::cell
