#pragma once

#include "core/base/object_reader.h"
#include "core/rcc/control_core.h"
#include "core/rcc/rules.h"

namespace takt::serve {

/// A number of a net. Errors go to the reader's diagnostics.
[[nodiscard]] rcc::NetId read_net(ObjectReader& reader, std::string_view key);

/// A rule as requests and messages carry it: "condition" (optional), "action", "otherwise" (optional). Nets are those
/// of the core; errors go to the reader's diagnostics.
[[nodiscard]] rcc::Rule read_rule(ObjectReader& reader, const rcc::ControlCore& core);

/// What a net is loaded with, beside the net: "cancel_bound_cycles", "goes_on", "stopped", "begins", "ends".
[[nodiscard]] rcc::LoadOptions read_load_options(ObjectReader& reader);

}  // namespace takt::serve
