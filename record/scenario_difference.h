#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "record/comparison.h"
#include "record/recording.h"

namespace takt::record {

/// What two documents do not share, by the pointer of the value: of an object's members each one, of arrays what is
/// left between what they share at their beginning and at their end. At most `most` differences.
[[nodiscard]] std::vector<ScenarioDifference> json_differences(const nlohmann::ordered_json& a,
                                                               const nlohmann::ordered_json& b, std::size_t most);

/// The same for the scenarios in two recordings; empty where one of them has none.
[[nodiscard]] std::vector<ScenarioDifference> scenario_differences(const Recording& a, const Recording& b);

}  // namespace takt::record
