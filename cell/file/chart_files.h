#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt::cell {

/// Puts the text of each chart that a node "charts" names in the place of its name, so that the document says all:
/// {"file": NAME, "scxml": TEXT}. Files lie below `folder`. Realtime: setup.
void read_charts(nlohmann::ordered_json& document, const std::filesystem::path& folder, Diagnostics& diagnostics);

}  // namespace takt::cell
