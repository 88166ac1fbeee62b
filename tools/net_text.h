#pragma once

#include <string>

#include "core/net/net_report.h"

namespace takt::tools {

/// The report of LOAD as tables for a terminal: certificate, demands, null paths, exclusions, free units, order.
[[nodiscard]] std::string to_text(const net::NetReport& report);

}  // namespace takt::tools
